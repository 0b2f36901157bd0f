#include "engine/simulation/trace.h"
#include "engine/turtle/scene/geometry.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::answering_test {
namespace {

/// Keeps what it is given, and answers the number of organs.
class Observer final : public turtle::EnvironmentProcess {
 public:
  struct Log {
    std::vector<turtle::QueryBatch> batches;
    int tickCount = 0;
  };
  Observer(std::shared_ptr<Log> log, bool needsGeometry) : log_(std::move(log)), needsGeometry_(needsGeometry) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "observer";
    description.needs.parameters = true;
    description.needs.geometry = needsGeometry_;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    log_->batches.push_back(queries);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const double organs = queries.geometry ? static_cast<double>(queries.geometry->organs.size()) : -1.0;
      replies.set(queries, query, 0, organs);
    }
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    ++log_->tickCount;
    return std::nullopt;
  }

 private:
  std::shared_ptr<Log> log_;
  bool needsGeometry_;
};

// a stem that gets a leaf each step: an interpreted triangle behind the communication module that stands for it
const char* const kLeafyModel =
    "Lsystem: 1\n"
    "derivation length: 3\n"
    "Axiom: A\n"
    "A --> F[?E(0)L(2)]A\n"
    "homomorphism\n"
    "L(s) --> ,(5){.f(s)-(90)f(s)}\n"
    "endlsystem\n";

struct ObservedRun {
  explicit ObservedRun(const char* model, bool needsGeometry, std::size_t plants = 1,
                       core::Compatibility compatibility = core::Compatibility::Espalier)
      : simulation(compileText(model, {}, compatibility), TestRun::placements(plants),
                   std::make_unique<Observer>(log, needsGeometry), {}) {
    expectSuccess(simulation.rewind());
  }
  std::shared_ptr<Observer::Log> log = std::make_shared<Observer::Log>();
  Simulation simulation;
};

TEST(Answering, AProcessThatNeedsGeometrySeesThePlantsAsTheyAreWhenTheyAsk) {
  ObservedRun run(kLeafyModel, true, 2);
  for (int step = 0; step < 3; ++step) {
    expectSuccess(run.simulation.step());
  }
  // the string of step 0 draws nothing and asks nothing, but is shown
  ASSERT_EQ(run.log->batches.size(), 3U);
  EXPECT_EQ(run.log->tickCount, 0);
  for (std::size_t step = 0; step < 3; ++step) {
    const turtle::QueryBatch& batch = run.log->batches[step];
    ASSERT_NE(batch.geometry, nullptr);
    EXPECT_EQ(batch.step, step);
    EXPECT_EQ(batch.geometry->segments.size(), 2 * step);
    ASSERT_EQ(batch.geometry->organs.size(), 2 * step);
    ASSERT_EQ(batch.size(), 2 * step);
    for (std::size_t organ = 0; organ < batch.geometry->organs.size(); ++organ) {
      EXPECT_EQ(batch.geometry->organs.plant[organ], batch.plant[organ]);
      EXPECT_EQ(batch.geometry->organs.module[organ], batch.module[organ] + 1);
      EXPECT_EQ(batch.geometry->organs.colour[organ], 5);
      EXPECT_EQ(batch.geometry->organs.symbol[organ], batch.geometry->organs.symbol[0]);
    }
  }
  // the second plant stands 4 to the right of the first
  const turtle::Geometry& last = *run.log->batches[2].geometry;
  EXPECT_EQ(last.start[2].x - last.start[0].x, 4.0);
  EXPECT_EQ(run.simulation.program().symbols[last.organs.symbol[0]].name, "L");
}

TEST(Answering, RepliesFromGeometryAreWritten) {
  ObservedRun run(kLeafyModel, true);
  for (int step = 0; step < 2; ++step) {
    expectSuccess(run.simulation.step());
  }
  expectSuccess(run.simulation.answer());
  EXPECT_EQ(run.simulation.stringText(), "F[?E(2)L(2)]F[?E(2)L(2)]A");
}

TEST(Answering, NoGeometryIsMadeForWhoDoesNotNeedIt) {
  ObservedRun run(kLeafyModel, false);
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  ASSERT_EQ(run.log->batches.size(), 1U);
  EXPECT_EQ(run.log->batches[0].geometry, nullptr);
  EXPECT_EQ(run.log->tickCount, 1);
}

TEST(Answering, DrawingForTheEnvironmentLeavesTheRunAsItIs) {
  ObservedRun with(kAskingModel, true);
  ObservedRun without(kAskingModel, false);
  // both answer -1 or 0 organs, which the model does not look at in a condition
  for (int step = 0; step < 6; ++step) {
    expectSuccess(with.simulation.step());
    expectSuccess(without.simulation.step());
    EXPECT_EQ(with.simulation.statistics().modules, without.simulation.statistics().modules) << step;
  }
}

TEST(Answering, ACompatibleModelTransmitsNothingInAStepWithoutQueries) {
  ObservedRun run("Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> FF\nendlsystem\n", true, 1,
                  core::Compatibility::Cpfg);
  expectSuccess(run.simulation.step());
  EXPECT_TRUE(run.log->batches.empty());
  EXPECT_EQ(run.log->tickCount, 0);
}

// ---- iterated coupling ----

/// Answers 1 + x / 2 plus the number of steps it has made, so that ?E(x) settles at 2 + 2 * steps; its state is that
/// number.
class Halver final : public turtle::EnvironmentProcess {
 public:
  struct Log {
    std::vector<std::uint32_t> iterations;  // of every batch
    std::uint64_t failingCall = 0;          // 1-based; 0: none
    std::uint64_t callCount = 0;
    std::uint64_t steps = 0;
    bool canSave = true;
  };
  explicit Halver(std::shared_ptr<Log> log) : log_(std::move(log)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "halver";
    description.needs.parameters = true;
    description.isStateful = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    log_->steps = 0;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (++log_->callCount == log_->failingCall) {
      return turtle::EnvironmentError{"halver is away.", true};
    }
    log_->iterations.push_back(queries.iteration);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      replies.set(queries, query, 0, 1.0 + 0.5 * queries.parametersOf(query)[0] + static_cast<double>(log_->steps));
    }
    ++log_->steps;
    return std::nullopt;
  }
  [[nodiscard]] std::string save() const override { return log_->canSave ? std::to_string(log_->steps) : ""; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    log_->steps = std::stoull(std::string(state));
    return std::nullopt;
  }

 private:
  std::shared_ptr<Log> log_;
};

// the parameter goes with the module from step to step
const char* const kCoupledModel =
    "Lsystem: 1\nderivation length: 3\nAxiom: F?E(0)\nE(x) --> E(x)\n?E(x) --> ?E(x)\nF --> FF\nendlsystem\n";

struct CoupledRun {
  explicit CoupledRun(Coupling coupling, std::shared_ptr<TraceRecorder> recorder = nullptr,
                      const char* model = kCoupledModel)
      : simulation(compileText(model), TestRun::placements(1),
                   recorder ? record(std::make_unique<Halver>(log), recorder) : std::make_unique<Halver>(log),
                   optionsOf(coupling)) {
    expectSuccess(simulation.rewind());
  }
  SimulationOptions optionsOf(Coupling coupling) {
    SimulationOptions options;
    options.coupling = coupling;
    options.messages = [this](core::MessageKind, std::string_view text) { messages.emplace_back(text); };
    return options;
  }
  [[nodiscard]] double value() { return simulation.string().parameters().back(); }

  std::vector<std::string> messages;
  std::shared_ptr<Halver::Log> log = std::make_shared<Halver::Log>();
  Simulation simulation;
};

TEST(Answering, ValuesBeyondTheParametersOfAModuleAreDroppedAndThatIsSaidOnce) {
  std::vector<std::string> messages;
  SimulationOptions options;
  options.messages = [&messages](core::MessageKind, std::string_view text) { messages.emplace_back(text); };
  // the observer sets a first parameter, and ?E has none
  Simulation simulation(compileText("Lsystem: 1\nAxiom: A\nA --> ?E?EA\nendlsystem\n"), TestRun::placements(1),
                        std::make_unique<Observer>(std::make_shared<Observer::Log>(), false), std::move(options));
  expectSuccess(simulation.rewind());
  for (int step = 0; step < 4; ++step) {
    expectSuccess(simulation.step());
  }
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0],
            "environment 'observer' gave 2 more values than the communication modules have parameters; they are "
            "dropped. (This is said once.)");
}

TEST(Answering, AnIteratedStepSettlesAtTheFixedPointOfBothSides) {
  CoupledRun run({.iterations = 100, .tolerance = 1e-9});
  expectSuccess(run.simulation.answer());
  // x = 1 + x / 2: each iteration halves the distance to 2, the last change is below the tolerance
  EXPECT_NEAR(run.value(), 2.0, 1e-8);
  EXPECT_EQ(run.log->steps, 1U);
  EXPECT_EQ(run.log->iterations.size(), 31U);
  EXPECT_EQ(run.log->iterations.back(), 30U);
  EXPECT_EQ(run.simulation.statistics().iterations, 31U);
  EXPECT_TRUE(run.messages.empty());
  // the next step begins from what the first left: x = 1 + x / 2 + 1
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.answer());
  EXPECT_NEAR(run.value(), 4.0, 1e-8);
  EXPECT_EQ(run.log->steps, 2U);
}

TEST(Answering, WithoutIterationsTheEnvironmentIsAskedOnce) {
  CoupledRun run({});
  expectSuccess(run.simulation.answer());
  EXPECT_EQ(run.value(), 1.0);
  EXPECT_EQ(run.simulation.statistics().iterations, 1U);
}

TEST(Answering, WhatAnEnvironmentNotesIsSaidOnce) {
  SimulationOptions options;
  std::vector<std::string> said;
  options.messages = [&said](core::MessageKind, std::string_view text) { said.emplace_back(text); };
  TestRun run(compileText(kCoupledModel), 1, options);
  run.log->note = "first";
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  run.log->note = "second";
  expectSuccess(run.simulation.step());
  EXPECT_EQ(said, (std::vector<std::string>{"first", "second"}));
}

TEST(Answering, AnIterationThatDoesNotSettleWarnsAndUsesTheLastAnswers) {
  CoupledRun run({.iterations = 3});
  expectSuccess(run.simulation.answer());
  EXPECT_EQ(run.value(), 1.75);
  ASSERT_EQ(run.messages.size(), 1U);
  EXPECT_EQ(run.messages[0],
            "step 1: the answers of environment 'halver' did not settle in 3 iterations; the last are used");
}

TEST(Answering, AnIterationThatFailsLeavesTheEnvironmentWhereItWas) {
  CoupledRun run({.iterations = 100, .tolerance = 1e-9});
  run.log->failingCall = 3;
  const std::string before = run.simulation.stringText();
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_TRUE(error->isRetryable);
  EXPECT_EQ(run.log->steps, 0U);
  EXPECT_EQ(run.simulation.stringText(), before);
  // the same step again, as if nothing had been
  expectSuccess(run.simulation.answer());
  EXPECT_NEAR(run.value(), 2.0, 1e-8);
  EXPECT_EQ(run.log->steps, 1U);
}

TEST(Answering, IteratingNeedsAnEnvironmentThatCanGoBack) {
  CoupledRun run({.iterations = 2});
  run.log->canSave = false;
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "environment 'halver' changes from step to step and cannot give its state back. Iterated coupling asks it "
      "several times from the same state: let it save and restore, or do not iterate. The simulation stays at step "
      "0.");
}

TEST(Answering, ASnapshotOfAnIteratedRunGoesOnIterating) {
  CoupledRun run({.iterations = 100, .tolerance = 1e-9});
  expectSuccess(run.simulation.step());
  core::StringSink answered;
  expectSuccess(run.simulation.answer());
  run.simulation.save(answered);
  CoupledRun resumed({});
  expectSuccess(resumed.simulation.restore(answered.text()));
  EXPECT_EQ(resumed.simulation.stateHash(), run.simulation.stateHash());
  for (int step = 0; step < 2; ++step) {
    expectSuccess(run.simulation.step());
    expectSuccess(resumed.simulation.step());
    expectSuccess(run.simulation.answer());
    expectSuccess(resumed.simulation.answer());
    EXPECT_EQ(resumed.simulation.stateHash(), run.simulation.stateHash());
  }
}

TEST(Answering, ATraceOfAnIteratedRunIsReplayed) {
  core::StringSink sink;
  const auto recorder = std::make_shared<TraceRecorder>(sink);
  CoupledRun run({.iterations = 100, .tolerance = 1e-9}, recorder);
  run.log->failingCall = 40;
  recorder->begin(run.simulation);
  int failures = 0;
  while (!run.simulation.isFinished()) {
    if (run.simulation.step()) {
      ++failures;
    } else {
      recorder->complete(run.simulation);
    }
  }
  EXPECT_EQ(failures, 1);
  const auto replayed = replayTrace(sink.text(), 1);
  ASSERT_TRUE(replayed.has_value()) << replayed.error();
  const auto& result = *replayed;
  EXPECT_EQ(result.steps, 3U);
  EXPECT_FALSE(result.divergence.has_value()) << result.divergence->message;
}

TEST(Answering, ATraceWithGeometryIsReplayedWithoutIt) {
  core::StringSink sink;
  const auto recorder = std::make_shared<TraceRecorder>(sink);
  const auto log = std::make_shared<Observer::Log>();
  Simulation simulation(compileText(kLeafyModel), TestRun::placements(1),
                        record(std::make_unique<Observer>(log, true), recorder), {});
  expectSuccess(simulation.rewind());
  recorder->begin(simulation);
  while (!simulation.isFinished()) {
    expectSuccess(simulation.step());
    recorder->complete(simulation);
  }
  const auto replayed = replayTrace(sink.text(), 1);
  ASSERT_TRUE(replayed.has_value()) << replayed.error();
  EXPECT_FALSE(replayed->divergence.has_value());
}

}  // namespace
}  // namespace espalier::simulation::answering_test
