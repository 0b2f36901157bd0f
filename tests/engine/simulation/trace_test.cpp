#include "engine/simulation/trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engine/language/compiler.h"

namespace espalier::simulation::trace_test {
namespace {

/// Answers the height, and fails in the steps it is told to.
class Height final : public turtle::EnvironmentProcess {
 public:
  explicit Height(std::uint64_t failingCall = 0) : failingCall_(failingCall) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "heights";
    description.needs.position = true;
    description.needs.parameters = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (++callCount_ == failingCall_) {
      return turtle::EnvironmentError{"heights is away.", true};
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      replies.set(queries, query, 0, queries.position[query].y + 0.1);
    }
    return std::nullopt;
  }

 private:
  std::uint64_t failingCall_;
  std::uint64_t callCount_ = 0;
};

// an axis with branches that ask at every tip; random lengths, so that the seed matters
constexpr std::string_view kModel =
    "Lsystem: 1\nderivation length: 6\nAxiom: A(1)?E(0)\n"
    "A(n) > ?E(h) : h < 30 --> F(1+ran(1))[+(30)A(n+1)?E(0)]F(0.5)A(n+1)\n"
    "endlsystem\n";

std::shared_ptr<const language::Program> compiled(std::string_view source = kModel) {
  core::MemoryFileProvider files({{"model.l", std::string(source)}});
  language::CompileInput input;
  input.modelFile = "model.l";
  const auto result = language::compile(input, files);
  EXPECT_NE(result.program, nullptr);
  return result.program;
}

/// A recorded run of `steps` steps.
std::string recorded(std::size_t plants = 1, std::uint64_t failingCall = 0, std::uint64_t restoreAfter = 0) {
  core::StringSink sink;
  const auto recorder = std::make_shared<TraceRecorder>(sink);
  SimulationOptions options;
  options.seed = 5;
  options.hasSeed = true;
  Simulation simulation(compiled(), std::vector<turtle::PlantPlacement>(plants),
                        record(std::make_unique<Height>(failingCall), recorder), options);
  EXPECT_FALSE(simulation.rewind().has_value());
  if (restoreAfter == 0) {
    recorder->begin(simulation);
  }
  while (!simulation.isFinished()) {
    if (simulation.step()) {
      continue;
    }
    if (simulation.completedSteps() == restoreAfter) {
      recorder->begin(simulation);
    } else if (simulation.completedSteps() > restoreAfter) {
      recorder->complete(simulation);
    }
  }
  return sink.take();
}

ReplayResult replayed(const std::string& trace, unsigned threads = 1) {
  const auto outcome = replayTrace(trace, threads);
  if (!outcome) {
    ADD_FAILURE() << outcome.error();
    return {};
  }
  return *outcome;
}

TEST(Trace, ARunIsTheSameWithoutItsEnvironmentForAnyNumberOfThreads) {
  const std::string trace = recorded(3);
  for (const unsigned threads : {1U, 2U, 4U}) {
    const ReplayResult result = replayed(trace, threads);
    EXPECT_FALSE(result.divergence.has_value()) << result.divergence->message;
    EXPECT_EQ(result.steps, 6U);
    EXPECT_GT(result.queries, 100U);
  }
}

TEST(Trace, ARunMayBeRecordedFromTheMiddle) {
  const ReplayResult result = replayed(recorded(1, 0, 3));
  EXPECT_FALSE(result.divergence.has_value()) << result.divergence->message;
  EXPECT_EQ(result.steps, 3U);
}

TEST(Trace, AStepThatFailedAndWasMadeAgainIsReplayedOnce) {
  const ReplayResult result = replayed(recorded(1, 3));
  EXPECT_FALSE(result.divergence.has_value()) << result.divergence->message;
  EXPECT_EQ(result.steps, 6U);
}

/// The events of a trace, for changing them.
std::vector<std::pair<std::size_t, TraceEvent>> eventsOf(const std::string& trace) {
  std::vector<std::pair<std::size_t, TraceEvent>> events;
  core::ViewSource source(trace);
  TraceReader reader(source);
  while (true) {
    auto read = reader.next();
    auto& event = read.value();
    if (!event) {
      return events;
    }
    events.emplace_back(events.size(), std::move(*event));
  }
}

TEST(Trace, AChangedByteOfAReplyIsNamedWithStepPlantAndModule) {
  std::string trace = recorded(2);
  // the reply to the last query of step 2: its bits are in the trace once as they were given
  TraceEvent step;
  for (auto& [index, event] : eventsOf(trace)) {
    if (event.kind == TraceEventKind::Step && event.step == 2) {
      step = std::move(event);
    }
  }
  ASSERT_GT(step.queries.size(), 3U);
  const double value = step.replies.values.back();
  const std::string bits(reinterpret_cast<const char*>(&value), sizeof(value));
  const std::size_t place = trace.find(bits);
  ASSERT_NE(place, std::string::npos);
  trace[place] = static_cast<char>(trace[place] ^ 1);
  const ReplayResult result = replayed(trace);
  ASSERT_TRUE(result.divergence.has_value());
  EXPECT_EQ(result.divergence->step, 2U);
  EXPECT_EQ(result.steps, 2U);
  const std::size_t found = step.queries.size() - 1;
  EXPECT_EQ(result.divergence->plant, step.queries.plant[found]);
  EXPECT_EQ(result.divergence->module, step.queries.module[found]);
  EXPECT_EQ(result.divergence->message,
            "step 2, plant " + std::to_string(step.queries.plant[found]) + ", module " +
                std::to_string(step.queries.module[found]) +
                " ('E'): the recorded reply is not the one that was given: the trace was changed there.");
}

TEST(Trace, ADifferenceInTheModelIsNamedAtItsFirstQueryOrString) {
  // the run of a trace with another model in its snapshot: what a changed program looks like
  const auto divergenceOf = [](const std::string& before, const std::string& after) {
    core::StringSink sink;
    const auto recorder = std::make_shared<TraceRecorder>(sink);
    const auto run = [&](const std::string& source, bool isRecorded) {
      Simulation simulation(compiled(source), {turtle::PlantPlacement{}}, record(std::make_unique<Height>(), recorder),
                            {});
      EXPECT_FALSE(simulation.rewind().has_value());
      // the start of one, the steps of the other
      if (!isRecorded) {
        recorder->begin(simulation);
        return;
      }
      for (int step = 0; step < 3; ++step) {
        EXPECT_FALSE(simulation.step().has_value());
        recorder->complete(simulation);
      }
    };
    run(after, false);
    run(before, true);
    const auto result = replayed(sink.take());
    return result.divergence ? result.divergence->message : std::string("(none)");
  };
  const auto model = [](const std::string& rule) {
    return "Lsystem: 1\nderivation length: 3\nAxiom: F(1)A?E(0)\n" + rule + "\nendlsystem\n";
  };
  EXPECT_EQ(divergenceOf(model("A --> F(1)A"), model("A --> F(1)A")), "(none)");
  EXPECT_EQ(divergenceOf(model("A --> F(1)A"), model("A --> F(2)A")),
            "after step 1, plant 0, module 0 or one of the 63 behind it: the string is not the recorded one.");
  EXPECT_EQ(divergenceOf("Lsystem: 1\nderivation length: 3\nAxiom: F(2)?E(0)\nA --> A\nendlsystem\n",
                         "Lsystem: 1\nderivation length: 3\nAxiom: F(1)?E(0)\nA --> A\nendlsystem\n"),
            "step 0, plant 0, module 2 ('E'): the position is (0, 1, 0), it was (0, 2, 0).");
  EXPECT_EQ(divergenceOf("Lsystem: 1\nderivation length: 3\nAxiom: F(1)?E(7)\nA --> A\nendlsystem\n",
                         "Lsystem: 1\nderivation length: 3\nAxiom: F(1)?E(0)\nA --> A\nendlsystem\n"),
            "step 0, plant 0, module 2 ('E'): parameter 1 is 0, it was 7.");
  EXPECT_EQ(divergenceOf("Lsystem: 1\nderivation length: 3\nAxiom: F(1)?E(0)?E(0)\nA --> A\nendlsystem\n",
                         "Lsystem: 1\nderivation length: 3\nAxiom: F(1)?E(0)\nA --> A\nendlsystem\n"),
            "step 0, plant 0, module 4 ('E'): the recorded run asks 2 queries in this step, this one 1.");
}

TEST(Trace, ASimulationWithoutEnvironmentIsTracedByItsStrings) {
  core::StringSink sink;
  const auto recorder = std::make_shared<TraceRecorder>(sink);
  Simulation simulation(compiled("Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> AA\nendlsystem\n"),
                        {turtle::PlantPlacement{}}, record(nullptr, recorder), {});
  ASSERT_FALSE(simulation.rewind().has_value());
  recorder->begin(simulation);
  for (int step = 0; step < 3; ++step) {
    ASSERT_FALSE(simulation.step().has_value());
    recorder->complete(simulation);
  }
  EXPECT_EQ(replayed(sink.text()).steps, 3U);
}

TEST(Trace, RubbishIsRefusedWithItsPlace) {
  const auto problemOf = [](const std::string& bytes) {
    const auto outcome = replayTrace(bytes, 1);
    return outcome ? std::string("(none)") : outcome.error();
  };
  const std::string trace = recorded();
  EXPECT_EQ(problemOf(""), "this is not a trace: it does not begin with ESPTRACE. --trace FILE records one.");
  EXPECT_EQ(problemOf("ESPALIER1234"),
            "this is not a trace: it does not begin with ESPTRACE. --trace FILE records one.");
  EXPECT_EQ(problemOf(std::string("ESPTRACE\x09\0\0\0", 12)),
            "this trace has version 9, this program reads 1 to 1. Use a newer program.");
  EXPECT_EQ(problemOf(trace.substr(0, 12)), "the trace is empty.");
  EXPECT_EQ(problemOf(trace.substr(0, trace.size() - 3)).find("the trace is cut off in the event at byte "), 0U);
  std::string damaged = trace;
  damaged[trace.size() - 10] = static_cast<char>(damaged[trace.size() - 10] ^ 4);
  EXPECT_NE(problemOf(damaged).find("does not have its checksum: the trace is damaged."), std::string::npos);
  // no byte changed anywhere crashes the reader
  for (std::size_t i = 0; i < trace.size(); i += 7) {
    std::string changed = trace;
    changed[i] = static_cast<char>(~changed[i]);
    const auto outcome = replayTrace(changed, 1);
    EXPECT_TRUE(!outcome || outcome->divergence.has_value()) << "byte " << i;
  }
}

}  // namespace
}  // namespace espalier::simulation::trace_test
