// The contract of every built-in process: replies that do not depend on the order of the queries, a state that can be
// saved and restored, and a description of the parameters that are sent and returned.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

#include "tests/environment/candidates.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::process_contract_test {
namespace {

class ProcessContract : public testing::TestWithParam<Candidate> {};

struct Query {
  core::Vec3 position;
  std::vector<double> parameters;
  std::uint64_t module;
  core::Vec3 heading;
};

/// Queries in a box of 10 with small whole numbers as first parameters, many of them equal.
std::vector<Query> randomQueries(const Candidate& candidate, std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(0.0, 10.0);
  std::uniform_int_distribution<int> few(1, 2);
  // a query of `multiple` has to say which field it is for
  std::uniform_int_distribution<std::size_t> length(candidate.name == "multiple" ? 1 : 0, candidate.parameterCount);
  std::vector<Query> queries;
  for (std::size_t i = 0; i < count; ++i) {
    Query query{{place(random), place(random), place(random)}, {}, i, {place(random), -1.0, 0.5}};
    if (i % 10 == 9) {
      query.position = queries[i / 2].position;
    }
    for (std::size_t k = length(random); k > 0; --k) {
      query.parameters.push_back(query.parameters.empty() ? few(random) : place(random) / 10.0);
    }
    queries.push_back(std::move(query));
  }
  return queries;
}

turtle::QueryBatch batchOf(const std::vector<Query>& queries, const std::vector<std::size_t>& order,
                           std::uint64_t step) {
  QueryBuilder builder;
  for (const std::size_t i : order) {
    builder.add(queries[i].position, queries[i].parameters);
    builder.batch().module.back() = queries[i].module;
    builder.batch().heading.back() = core::normalised(queries[i].heading);
  }
  builder.batch().step = step;
  return builder.batch();
}

std::vector<std::size_t> inOrder(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

TEST_P(ProcessContract, RepliesDoNotDependOnTheOrderOfTheQueries) {
  std::mt19937_64 random(7);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  const auto shuffled = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process && shuffled);
  for (std::uint64_t step = 0; step < 3; ++step) {
    const auto queries = randomQueries(GetParam(), 300, random);
    auto order = inOrder(queries.size());
    const auto expected = answersOf(*process, batchOf(queries, order, step));
    std::shuffle(order.begin(), order.end(), random);
    const auto found = answersOf(*shuffled, batchOf(queries, order, step));
    for (std::size_t k = 0; k < order.size(); ++k) {
      ASSERT_EQ(found[k], expected[order[k]]) << "query " << order[k] << " of step " << step;
    }
    ASSERT_EQ(process->save(), shuffled->save());
  }
}

// a snapshot can come from a stranger: whatever number stands in the state, it is refused, or the process goes on
TEST_P(ProcessContract, AStateWithAnyNumberInItIsRefusedOrGoesOn) {
  std::mt19937_64 random(23);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  const auto queries = randomQueries(GetParam(), 30, random);
  const auto batch = batchOf(queries, inOrder(queries.size()), 0);
  (void)answersOf(*process, batch);
  const std::string state = process->save();
  const std::array<std::uint64_t, 8> numbers{0,
                                             ~0ULL,
                                             0x7FFFFFFFFFFFFFFFULL,
                                             0x7FFFFFFFULL,
                                             std::bit_cast<std::uint64_t>(std::numeric_limits<double>::quiet_NaN()),
                                             std::bit_cast<std::uint64_t>(std::numeric_limits<double>::infinity()),
                                             std::bit_cast<std::uint64_t>(-1e300),
                                             std::bit_cast<std::uint64_t>(1e-320)};
  // the first numbers are counts and names; of the others a few
  const std::size_t places = state.size() / 8;
  for (std::size_t place = 0; place < places; place += place < 12 ? 1 : std::max<std::size_t>(places / 40, 1)) {
    for (const std::uint64_t number : numbers) {
      std::string changed = state;
      std::memcpy(changed.data() + 8 * place, &number, 8);
      const auto refused = process->restore(changed);
      if (refused) {
        EXPECT_NE(refused->message, "");
        continue;
      }
      turtle::ReplyBatch replies;
      replies.prepare(batch);
      (void)process->step(batch, replies);
      EXPECT_LT(process->save().size(), state.size() + 1'000'000U) << "place " << place;
    }
  }
  ASSERT_FALSE(process->restore(state).has_value());
}

TEST_P(ProcessContract, ARestoredStateGoesOnAsTheSavedOne) {
  std::mt19937_64 random(11);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  const auto step = [&](turtle::EnvironmentProcess& one, const std::vector<Query>& queries, std::uint64_t number) {
    return answersOf(one, batchOf(queries, inOrder(queries.size()), number));
  };
  for (std::uint64_t number = 0; number < 3; ++number) {
    step(*process, randomQueries(GetParam(), 100, random), number);
  }
  const std::string state = process->save();
  const auto restored = openProcess(GetParam().name, GetParam().configuration);
  const auto error = restored->restore(state);
  ASSERT_FALSE(error.has_value()) << error->message;
  EXPECT_EQ(restored->save(), state);
  for (std::uint64_t number = 3; number < 6; ++number) {
    const auto queries = randomQueries(GetParam(), 100, random);
    ASSERT_EQ(step(*process, queries, number), step(*restored, queries, number));
    ASSERT_FALSE(process->tick(number).has_value());
    ASSERT_FALSE(restored->tick(number).has_value());
  }
  EXPECT_EQ(restored->save(), process->save());

  // opened again it is as new
  ASSERT_FALSE(restored->open({}).has_value());
  EXPECT_EQ(restored->save(), openProcess(GetParam().name, GetParam().configuration)->save());
}

TEST_P(ProcessContract, DamagedStateIsRefusedAndChangesNothing) {
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  if (!process->describe().isStateful) {
    EXPECT_EQ(process->save(), "");
    return;
  }
  const std::string state = process->save();
  const auto error = process->restore(state + "x");
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("saved state"), std::string::npos) << error->message;
  EXPECT_TRUE(process->restore(std::string_view(state).substr(0, state.size() / 2)).has_value());
  EXPECT_EQ(process->save(), state);
}

TEST_P(ProcessContract, DescriptionNamesEveryValueWithItsUnit) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  const auto process = openProcess(GetParam().name, GetParam().configuration, context);
  ASSERT_TRUE(process);
  const auto description = process->describe();
  EXPECT_EQ(description.name, GetParam().name);
  EXPECT_EQ(description.summary.back(), '.');
  for (const auto* variables : {&description.inputs, &description.outputs}) {
    for (const auto& variable : *variables) {
      EXPECT_FALSE(variable.name.empty());
      EXPECT_FALSE(variable.unit.empty()) << variable.name;
      // light is measured per square metre and in micromoles whatever the world's unit
      const bool isOfLight = variable.unit.substr(0, 1) == "W" || variable.unit.substr(0, 4) == "umol";
      EXPECT_TRUE(isOfLight || variable.unit == "mol" || variable.unit.find('m') == std::string::npos ||
                  variable.unit.find("cm") != std::string::npos)
          << variable.name << " has the unit " << variable.unit << " in a world of centimetres";
    }
  }
}

TEST_P(ProcessContract, AStepWithoutQueriesIsNoError) {
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  EXPECT_TRUE(answersOf(*process, QueryBuilder().batch()).empty());
}

INSTANTIATE_TEST_SUITE_P(Processes, ProcessContract, testing::ValuesIn(candidates()), nameOf);

TEST(ProcessContracts, CoverEveryProcess) {
  const auto all = candidates();
  for (const std::string& name : processNames()) {
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Candidate& one) { return one.name == name; }))
        << "tests/environment/processes/" << name << ".json has no \"queries\"";
  }
}

}  // namespace
}  // namespace espalier::environment::process_contract_test
