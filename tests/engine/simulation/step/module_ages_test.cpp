#include "engine/simulation/step/module_ages.h"

#include <string>

#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::module_ages_test {
namespace {

constexpr const char* kAgingModel =
    "Lsystem: 1\nderivation length: 5\nAxiom: A\nA --> I(1)[+A]A\nI(l) --> I(l*2)\nendlsystem\n";

/// The steps in which the modules came, `?` where it is not known.
std::string birthsOf(const Simulation& simulation, std::size_t plant = 0) {
  std::string text;
  for (const std::uint64_t step : simulation.moduleBirths(plant)) {
    text += (text.empty() ? "" : " ") + (step == Simulation::kUnknownBirth ? "?" : std::to_string(step));
  }
  return text;
}

TEST(ModuleAges, ModulesThatGoOnKeepTheirStep) {
  TestRun run(compileText(kAgingModel));
  run.simulation.followAges(true);
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(birthsOf(run.simulation), "0");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(birthsOf(run.simulation), "1 1 1 1 1 0");
  expectSuccess(run.simulation.step());
  // I(2)[+ I(1)[+A]A ] I(1)[+A]A
  EXPECT_EQ(birthsOf(run.simulation), "1 1 1 2 2 2 2 2 1 1 2 2 2 2 2 0");
  // the history before a snapshot is not known after it
  const std::string second = snapshotOf(run.simulation);
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(birthsOf(run.simulation), "0");
  expectSuccess(run.simulation.restore(second));
  EXPECT_EQ(birthsOf(run.simulation), "? ? ? ? ? ? ? ? ? ? ? ? ? ? ? ?");
  run.simulation.followAges(false);
  expectSuccess(run.simulation.step());
  EXPECT_EQ(birthsOf(run.simulation), "");
}

TEST(ModuleAges, AStepThatFailsChangesNothing) {
  TestRun run(
      compileText("Lsystem: 1\nderivation length: 5\nAxiom: BA(1)\n"
                  "B --> CB\nA(x) : x > 2 --> A(exp(1000))\nA(x) --> A(x+1)\nendlsystem\n"),
      2);
  run.simulation.followAges(true);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.step());
  EXPECT_TRUE(run.simulation.step().has_value());
  for (const std::size_t plant : {0U, 1U}) {
    EXPECT_EQ(birthsOf(run.simulation, plant), "1 2 0 0");
  }
}

}  // namespace
}  // namespace espalier::simulation::module_ages_test
