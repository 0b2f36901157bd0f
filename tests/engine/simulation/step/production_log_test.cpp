#include "engine/simulation/step/production_log.h"

#include <map>
#include <string>

#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::production_log_test {
namespace {

constexpr const char* kApexModel =
    "Lsystem: 1\n"
    "derivation length: 5\n"
    "Axiom: A\n"
    "A --> BA\n"
    "B --> F\n"
    "C --> A\n"
    "endlsystem\n";

/// `last/total` of the model's productions in order, behind the step since which they are counted.
std::string countsOf(const Simulation& simulation) {
  const std::shared_ptr<const ProductionUses> uses = simulation.productionUses();
  if (uses == nullptr) {
    return "none";
  }
  std::string text = std::to_string(uses->since) + "-" + std::to_string(uses->step) + ":";
  for (const language::Production& production : simulation.program().systems.front().productions.productions) {
    const auto use = uses->uses.find(&production);
    const ProductionUse count = use == uses->uses.end() ? ProductionUse{} : use->second;
    text += " " + std::to_string(count.last) + "/" + std::to_string(count.total);
  }
  return text;
}

TEST(ProductionLog, CountsWhatEachStepApplies) {
  TestRun run(compileText(kApexModel));
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(countsOf(run.simulation), "none");
  run.simulation.countProductions(true);
  EXPECT_EQ(countsOf(run.simulation), "0-0: 0/0 0/0 0/0");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(countsOf(run.simulation), "0-1: 1/1 0/0 0/0");
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(countsOf(run.simulation), "0-3: 1/3 1/2 0/0");
  EXPECT_EQ(run.simulation.stringText(), "FFBA");
  run.simulation.countProductions(false);
  EXPECT_EQ(countsOf(run.simulation), "none");
}

TEST(ProductionLog, ARunThatGoesBackFindsTheCountsOfThatStep) {
  TestRun run(compileText(kApexModel));
  expectSuccess(run.simulation.rewind());
  run.simulation.countProductions(true);
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  const std::string second = snapshotOf(run.simulation);
  expectSuccess(run.simulation.step());
  const std::string third = snapshotOf(run.simulation);
  expectSuccess(run.simulation.restore(second));
  EXPECT_EQ(countsOf(run.simulation), "0-2: 1/2 1/1 0/0");
  expectSuccess(run.simulation.restore(third));
  EXPECT_EQ(countsOf(run.simulation), "0-3: 1/3 1/2 0/0");
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(countsOf(run.simulation), "0-0: 0/0 0/0 0/0");
  // a step that is made again takes the place of the old ones
  expectSuccess(run.simulation.step());
  EXPECT_EQ(countsOf(run.simulation), "0-1: 1/1 0/0 0/0");
  expectSuccess(run.simulation.restore(third));
  EXPECT_EQ(countsOf(run.simulation), "3-3: 0/0 0/0 0/0");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(countsOf(run.simulation), "3-4: 1/1 1/1 0/0");
}

TEST(ProductionLog, AStepThatFailsCountsNothing) {
  TestRun run(
      compileText("Lsystem: 1\nderivation length: 5\nAxiom: BA(1)?E(0)\n"
                  "B --> BC\nA(x) : x > 2 --> A(exp(1000))\nA(x) --> A(x+1)\nendlsystem\n"));
  expectSuccess(run.simulation.rewind());
  run.simulation.countProductions(true);
  expectSuccess(run.simulation.step());
  run.log->nextError = turtle::EnvironmentError{};
  EXPECT_TRUE(run.simulation.step().has_value());
  EXPECT_EQ(countsOf(run.simulation), "0-1: 1/1 0/0 1/1");
  expectSuccess(run.simulation.step());
  // when the infinite number comes, B has been rewritten
  EXPECT_TRUE(run.simulation.step().has_value());
  EXPECT_EQ(countsOf(run.simulation), "0-2: 1/2 0/0 1/2");
}

TEST(ProductionLog, AddsThePlantsOfAForest) {
  SimulationOptions options;
  options.threads = 2;
  TestRun run(compileText(kApexModel), 3, options, false);
  expectSuccess(run.simulation.rewind());
  run.simulation.countProductions(true);
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(countsOf(run.simulation), "0-2: 3/6 3/3 0/0");
}

TEST(ProductionLog, KnowsTheLastThousandSteps) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 5\nAxiom: A\nA --> A\nendlsystem\n"));
  expectSuccess(run.simulation.rewind());
  run.simulation.countProductions(true);
  std::map<int, std::string> states;
  for (int step = 1; step <= 1500; ++step) {
    expectSuccess(run.simulation.step());
    if (step == 400 || step == 600) {
      states[step] = snapshotOf(run.simulation);
    }
  }
  EXPECT_EQ(countsOf(run.simulation), "0-1500: 1/1500");
  expectSuccess(run.simulation.restore(states[600]));
  EXPECT_EQ(countsOf(run.simulation), "0-600: 1/600");
  expectSuccess(run.simulation.restore(states[400]));
  EXPECT_EQ(countsOf(run.simulation), "400-400: 0/0");
}

TEST(ProductionLog, TakesBoundedMemory) {
  std::string text = "Lsystem: 1\nderivation length: 5\nAxiom: ";
  std::string productions;
  for (int i = 0; i < 2000; ++i) {
    const std::string number = std::to_string(i);
    text += "A(" + number + ")";
    productions += "A(x) : x==" + number + " --> A(x)\n";
  }
  TestRun run(compileText(text + "\n" + productions + "endlsystem\n"));
  expectSuccess(run.simulation.rewind());
  const std::uint64_t before = run.simulation.keptBytes();
  run.simulation.countProductions(true);
  for (int step = 1; step <= 100; ++step) {
    expectSuccess(run.simulation.step());
    ASSERT_LE(run.simulation.keptBytes(), before + 5'000'000) << step;
  }
  EXPECT_GT(run.simulation.keptBytes(), before + 1'000'000);
  const auto uses = run.simulation.productionUses();
  ASSERT_EQ(uses->uses.size(), 2000U);
  EXPECT_EQ(uses->uses.begin()->second.total, 100U);
}

}  // namespace
}  // namespace espalier::simulation::production_log_test
