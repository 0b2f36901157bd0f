#include "engine/turtle/geometry.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation {
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

}  // namespace
}  // namespace espalier::simulation
