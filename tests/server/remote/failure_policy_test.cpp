#include "server/remote/failure_policy.h"

#include <filesystem>

#include "engine/simulation/trace.h"
#include "server/remote/trace_file.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::failure_policy_test {
namespace {

/// Answers a number, or fails while it is told to.
class Switched final : public turtle::EnvironmentProcess {
 public:
  explicit Switched(double value, const bool* isAway = nullptr) : value_(value), isAway_(isAway) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "switched";
    description.needs.width = value_ > 1.0;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return failure();
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (auto error = failure()) {
      // half an answer, of which nothing may be used
      replies.set(queries, 0, 0, -1.0);
      return error;
    }
    replies.set(queries, 0, 0, value_);
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override { return failure(); }
  [[nodiscard]] std::string save() const override { return value_ > 1.0 ? "two" : "o:ne"; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return state == save() ? std::nullopt
                           : std::optional(turtle::EnvironmentError{"wrong state " + std::string(state), false});
  }

 private:
  [[nodiscard]] std::optional<turtle::EnvironmentError> failure() const {
    return isAway_ != nullptr && *isAway_ ? std::optional(turtle::EnvironmentError{"switched is away.", true})
                                          : std::nullopt;
  }
  double value_;
  const bool* isAway_;
};

turtle::QueryBatch oneQuery(std::uint64_t step) {
  turtle::QueryBatch queries;
  queries.step = step;
  queries.plant = {0};
  queries.module = {0};
  queries.symbol = {0};
  queries.parameterOffset = {0, 1};
  queries.parameters = {5.0};
  queries.followingOffset = {0, 0};
  return queries;
}

/// The value of the only query's reply; nothing: it keeps what it sent.
std::optional<double> answerOf(turtle::EnvironmentProcess& process, std::uint64_t step) {
  const turtle::QueryBatch queries = oneQuery(step);
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  EXPECT_FALSE(process.step(queries, replies).has_value());
  return replies.isSet[0] != 0 ? std::optional(replies.values[0]) : std::nullopt;
}

TEST(FailurePolicy, KeepLeavesWhatWasSentUntilTheEnvironmentIsBack) {
  bool isAway = false;
  std::vector<std::string> heard;
  const auto process = withFailurePolicy(
      std::make_unique<Switched>(1.0, &isAway), nullptr,
      [&](std::uint64_t step, const std::string& message) { heard.push_back(std::to_string(step) + " " + message); });
  EXPECT_EQ(answerOf(*process, 0), 1.0);
  isAway = true;
  EXPECT_FALSE(process->open({}).has_value());
  EXPECT_EQ(answerOf(*process, 1), std::nullopt);
  EXPECT_FALSE(process->tick(2).has_value());
  isAway = false;
  EXPECT_EQ(answerOf(*process, 3), 1.0);
  EXPECT_EQ(heard, (std::vector<std::string>{"0 switched is away. The modules keep what they sent.",
                                             "1 switched is away. The modules keep what they sent.",
                                             "2 switched is away. The modules keep what they sent."}));
}

TEST(FailurePolicy, AFallbackAnswersInItsPlaceAndIsPartOfTheNeedsAndTheState) {
  bool isAway = true;
  std::string heard;
  const auto process = withFailurePolicy(std::make_unique<Switched>(1.0, &isAway), std::make_unique<Switched>(2.0),
                                         [&](std::uint64_t, const std::string& message) { heard = message; });
  EXPECT_TRUE(process->describe().needs.width);
  EXPECT_EQ(answerOf(*process, 0), 2.0);
  EXPECT_EQ(heard, "switched is away. The built-in 'switched' answers in its place.");
  EXPECT_EQ(process->save(), "4:o:netwo");
  EXPECT_FALSE(process->restore(process->save()).has_value());
  for (const char* wrong : {"", "x", "9:abc", "4o:netwo", "4:o:nefour"}) {
    EXPECT_TRUE(process->restore(wrong).has_value()) << wrong;
  }
}

/// The events of the only trace in a folder.
std::vector<simulation::TraceEvent> eventsIn(const std::string& folder) {
  std::vector<simulation::TraceEvent> events;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::string bytes;
    EXPECT_EQ(TraceFileSource::open(entry.path().string()).value()->read(SIZE_MAX, bytes), std::nullopt);
    core::ViewSource source(bytes);
    simulation::TraceReader reader(source);
    while (true) {
      auto read = reader.next();
      if (!read || !*read) {
        EXPECT_TRUE(read.has_value()) << read.error();
        break;
      }
      events.push_back(std::move(**read));
    }
    const auto replayed = simulation::replayTrace(bytes, 2);
    EXPECT_TRUE(replayed.has_value() && !replayed->divergence);
  }
  return events;
}

TEST(FailurePolicy, ASimulationOfTheServerGoesOnAndItsTraceSaysWhy) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(
      *client, kGrowth, R"([{"type":"offered","name":"mylight","policy":"fallback:height"}])", R"("trace":true)");
  resultOf(client->request("simulation.run", named(simulation)));
  EXPECT_EQ(member(resultOf(client->request("simulation.get", named(simulation, R"("what":"string")"))), "string"),
            "F(1)F(1)F(1)?E(3)");
  std::size_t failures = 0;
  std::size_t steps = 0;
  for (const simulation::TraceEvent& event : eventsIn(folder.path() + "/traces")) {
    steps += event.kind == simulation::TraceEventKind::Complete ? 1U : 0U;
    if (event.kind == simulation::TraceEventKind::Failure) {
      ++failures;
      EXPECT_NE(event.message.find("environment 'mylight' is not connected"), std::string::npos) << event.message;
      EXPECT_NE(event.message.find("The built-in 'height' answers in its place."), std::string::npos);
    }
  }
  EXPECT_EQ(steps, 6U);
  EXPECT_GE(failures, 4U);
}

TEST(FailurePolicy, WrongPoliciesAndTracesWithoutADataFolderAreRefused) {
  const RunningServer server;
  const auto client = connectTo(server);
  const auto refused = [&](const std::string& policy) {
    return errorOf(
               client->request("simulation.create",
                               createParams(kGrowth, R"([{"type":"offered","name":"x","policy":")" + policy + "\"}]")))
        .message;
  };
  EXPECT_EQ(refused("hope"),
            "params.environment[0].policy: expected fail, keep or fallback:NAME of a built-in, found \"hope\"");
  EXPECT_EQ(refused("fallback:nothing").find("params.environment[0].policy: "), 0U);
  EXPECT_EQ(errorOf(client->request("simulation.create", createParams(kGrowth, {}, R"("trace":true)"))).message,
            "params.trace: this server keeps nothing; start it with --data to have traces");
}

}  // namespace
}  // namespace espalier::server::failure_policy_test
