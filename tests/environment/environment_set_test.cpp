#include "environment/environment_set.h"

#include <gtest/gtest.h>

#include "engine/turtle/scene/geometry.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::environment_set_test {
namespace {

using turtle::EnvironmentError;
using turtle::EnvironmentProcess;

/// Answers `offset` + the sum of parameter 1 of all queries so far in p1, and counts ticks. Fails on demand.
class Adder final : public EnvironmentProcess {
 public:
  Adder(double offset, bool isStateful) : offset_(offset), isStateful_(isStateful) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "adder",
            .summary = "Adds.",
            .needs = {.heading = isStateful_, .parameters = true},
            .inputs = {{"amount", "mol", ""}},
            .outputs = {{"sum", "mol", ""}},
            .isStateful = isStateful_};
  }
  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext&) override {
    sum_ = 0;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    if (isFailing) {
      return EnvironmentError{"The adder is tired.", true};
    }
    modules = queries.module;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      sum_ += isStateful_ ? queries.parametersOf(query)[0] : 0.0;
      replies.set(queries, query, 0, offset_ + sum_);
      ++replies.answeredCount;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t) override {
    ++tickCount;
    return std::nullopt;
  }
  [[nodiscard]] std::string save() const override { return isStateful_ ? std::to_string(sum_) : std::string(); }
  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
    if (state == "bad") {
      return EnvironmentError{"Not a sum.", false};
    }
    sum_ = state.empty() ? 0.0 : std::stod(std::string(state));
    return std::nullopt;
  }

  bool isFailing = false;
  int tickCount = 0;
  std::vector<std::uint64_t> modules;

 private:
  double offset_;
  bool isStateful_;
  double sum_ = 0;
};

struct Pair {
  Adder* first;
  Adder* second;
  std::unique_ptr<EnvironmentProcess> set;
};

Pair makePair() {
  auto first = std::make_unique<Adder>(100, true);
  auto second = std::make_unique<Adder>(200, true);
  Pair pair{first.get(), second.get(), nullptr};
  std::vector<std::pair<std::string, std::unique_ptr<EnvironmentProcess>>> processes;
  processes.emplace_back("soil", std::move(first));
  processes.emplace_back("light", std::move(second));
  pair.set = makeEnvironmentSet(std::move(processes));
  turtle::EnvironmentContext context;
  context.symbols = {"E", "Light", "Wind"};
  EXPECT_FALSE(pair.set->open(context));
  return pair;
}

QueryBuilder mixedQueries() {
  QueryBuilder builder;
  builder.add({}, {1, 7}, 0).add({}, {2}, 1).add({}, {3}, 0).add({}, {4, 8, 9}, 1);
  return builder;
}

TEST(EnvironmentSet, PlainQueriesGoToTheFirstAndDeclaredOnesByName) {
  Pair pair = makePair();
  QueryBuilder builder = mixedQueries();
  const ReplyTable table = answersOf(*pair.set, builder.batch());
  EXPECT_EQ(pair.first->modules, (std::vector<std::uint64_t>{0, 2}));
  EXPECT_EQ(pair.second->modules, (std::vector<std::uint64_t>{1, 3}));
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{101.0, std::nullopt}));
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{202.0}));
  EXPECT_EQ(table[2], (std::vector<std::optional<double>>{104.0}));
  EXPECT_EQ(table[3], (std::vector<std::optional<double>>{206.0, std::nullopt, std::nullopt}));
}

TEST(EnvironmentSet, CountsOfAllAreAddedUp) {
  Pair pair = makePair();
  QueryBuilder builder = mixedQueries();
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  ASSERT_FALSE(pair.set->step(builder.batch(), replies));
  EXPECT_EQ(replies.answeredCount, 4U);
  EXPECT_EQ(replies.surplusCount, 0U);
}

TEST(EnvironmentSet, AQueryForNobodyIsAnErrorThatListsTheNames) {
  Pair pair = makePair();
  QueryBuilder builder;
  builder.add({}, {1}, 0).add({}, {1}, 2);
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const std::string before = pair.set->save();
  const auto error = pair.set->step(builder.batch(), replies);
  ASSERT_TRUE(error);
  EXPECT_EQ(
      error->message,
      "No environment process is named 'Wind', but the model asks ?Wind(...). Available: soil, light. Give a process "
      "this name, or ask ?E(...), which goes to the first one.");
  EXPECT_FALSE(error->isRetryable);
  EXPECT_EQ(pair.set->save(), before);
}

TEST(EnvironmentSet, AFailureLeavesTheStateOfAllAsBefore) {
  Pair pair = makePair();
  QueryBuilder builder = mixedQueries();
  answersOf(*pair.set, builder.batch());
  const std::string before = pair.set->save();
  pair.second->isFailing = true;
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const auto error = pair.set->step(builder.batch(), replies);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message, "The adder is tired.");
  EXPECT_TRUE(error->isRetryable);
  EXPECT_EQ(pair.set->save(), before);
  pair.second->isFailing = false;
  EXPECT_EQ(answersOf(*pair.set, builder.batch())[0][0], 105.0);
}

TEST(EnvironmentSet, AProcessWithoutQueriesInAStepTicks) {
  Pair pair = makePair();
  QueryBuilder builder;
  builder.add({}, {1}, 0);
  answersOf(*pair.set, builder.batch());
  EXPECT_EQ(pair.first->tickCount, 0);
  EXPECT_EQ(pair.second->tickCount, 1);
  ASSERT_FALSE(pair.set->tick(1));
  EXPECT_EQ(pair.first->tickCount, 1);
  EXPECT_EQ(pair.second->tickCount, 2);
}

TEST(EnvironmentSet, RestoringASaveContinuesAllProcesses) {
  Pair pair = makePair();
  QueryBuilder builder = mixedQueries();
  answersOf(*pair.set, builder.batch());
  const std::string state = pair.set->save();
  const ReplyTable next = answersOf(*pair.set, builder.batch());
  Pair other = makePair();
  ASSERT_FALSE(other.set->restore(state));
  EXPECT_EQ(other.set->save(), state);
  EXPECT_EQ(answersOf(*other.set, builder.batch()), next);
}

TEST(EnvironmentSet, AStateOfOtherEnvironmentsIsRefusedAndChangesNothing) {
  Pair pair = makePair();
  QueryBuilder builder = mixedQueries();
  answersOf(*pair.set, builder.batch());
  const std::string before = pair.set->save();
  for (const std::string& state : {std::string("x"), before.substr(0, before.size() - 1), before + "x"}) {
    const auto error = pair.set->restore(state);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->message,
              "The saved state of the environment does not belong to these processes (soil, light). Use the same "
              "environments in the same order as when it was saved.");
    EXPECT_EQ(pair.set->save(), before);
  }
}

TEST(EnvironmentSet, DescriptionMergesNeedsAndNamesVariablesByProcess) {
  Pair pair = makePair();
  const auto description = pair.set->describe();
  EXPECT_EQ(description.name, "soil, light");
  EXPECT_TRUE(description.needs.parameters);
  EXPECT_TRUE(description.needs.heading);
  EXPECT_FALSE(description.needs.position);
  ASSERT_EQ(description.outputs.size(), 2U);
  EXPECT_EQ(description.outputs[1].name, "light.sum");
  EXPECT_EQ(description.outputs[1].unit, "mol");
  EXPECT_TRUE(description.isStateful);
}

TEST(EnvironmentSet, OneProcessWithoutANameTakesEverything) {
  auto adder = std::make_unique<Adder>(1, false);
  EnvironmentProcess* raw = adder.get();
  std::vector<std::pair<std::string, std::unique_ptr<EnvironmentProcess>>> processes;
  processes.emplace_back("", std::move(adder));
  EXPECT_EQ(makeEnvironmentSet(std::move(processes)).get(), raw);
}

TEST(EnvironmentSet, OneNamedProcessAnswersItsNameAndPlainQueriesOnly) {
  std::vector<std::pair<std::string, std::unique_ptr<EnvironmentProcess>>> processes;
  processes.emplace_back("light", std::make_unique<Adder>(1, false));
  const auto set = makeEnvironmentSet(std::move(processes));
  turtle::EnvironmentContext context;
  context.symbols = {"E", "Light", "Wind"};
  ASSERT_FALSE(set->open(context));
  QueryBuilder builder;
  builder.add({}, {1}, 0).add({}, {1}, 1);
  EXPECT_EQ(firstValues(answersOf(*set, builder.batch())), (std::vector<double>{1, 1}));
  QueryBuilder wrong;
  wrong.add({}, {1}, 2);
  turtle::ReplyBatch replies;
  replies.prepare(wrong.batch());
  EXPECT_TRUE(set->step(wrong.batch(), replies));
}

/// Needs geometry and counts its steps.
class Looker final : public EnvironmentProcess {
 public:
  explicit Looker(std::vector<std::size_t>& steps) : steps_(&steps) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "looker";
    description.needs.geometry = true;
    return description;
  }
  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries, turtle::ReplyBatch&) override {
    steps_->push_back(queries.geometry != nullptr ? queries.geometry->segments.size() : 0);
    return std::nullopt;
  }

 private:
  std::vector<std::size_t>* steps_;
};

TEST(EnvironmentSet, GeometryGoesToWhoNeedsItAlsoWithoutQueries) {
  std::vector<std::size_t> steps;
  std::vector<std::pair<std::string, std::unique_ptr<EnvironmentProcess>>> processes;
  processes.emplace_back("adder", std::make_unique<Adder>(1.0, false));
  processes.emplace_back("looker", std::make_unique<Looker>(steps));
  const auto set = makeEnvironmentSet(std::move(processes));
  EXPECT_TRUE(set->describe().needs.geometry);
  turtle::QueryBatch queries;
  queries.clear();
  auto geometry = std::make_shared<turtle::Geometry>();
  geometry->segments.plant.assign(3, 0);
  queries.geometry = geometry;
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  EXPECT_FALSE(set->step(queries, replies).has_value());
  EXPECT_EQ(steps, (std::vector<std::size_t>{3}));
}

}  // namespace
}  // namespace espalier::environment::environment_set_test
