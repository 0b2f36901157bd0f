// Strings of more than 2^32 modules: every count and index on the way is a 64-bit number.

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <string>

#include "tests/engine/simulation/simulation_fixture.h"
#include "tests/support/sanitized.h"

namespace espalier::simulation::long_string_test {
namespace {

std::uint64_t availableBytes() {
  std::ifstream file("/proc/meminfo");
  std::string word;
  std::uint64_t kilobytes = 0;
  while (file >> word) {
    if (word == "MemAvailable:") {
      file >> kilobytes;
      break;
    }
  }
  return kilobytes * 1024;
}

// run by `./dev test --all` alone: its name begins with Long

TEST(LongString, HasMoreThanTwoToThe32ModulesAndItsLastQueryIsAnswered) {
  constexpr std::uint64_t kNeededBytes = 13'000'000'000;
  if (kIsSanitized) {
    GTEST_SKIP() << "a sanitizer multiplies the 10 GB of the string";
  }
  if (availableBytes() < kNeededBytes) {
    GTEST_SKIP() << "needs 13 GB of memory, " << availableBytes() / 1'000'000'000 << " GB are available";
  }
  // N^(41^k) after step k: 41^6 = 4,750,104,241. Only one string is large. `%` appears in the last step: it keeps the
  // turtle from walking over the branch, and nothing is derived after it
  std::string production = "N --> ";
  for (int i = 0; i < 41; ++i) {
    production += 'N';
  }
  const std::string model = "Lsystem: 1\nderivation length: 6\nAxiom: [X(1)N]B?E(0)\n" + production +
                            "\nX(n) : n<6 --> X(n+1)\nX(n) : n==6 --> %\nendlsystem\n";
  SimulationOptions options;
  options.limits.maximumModules = 5'000'000'000;
  options.limits.maximumStringBytes = 10'000'000'000;
  const auto log = std::make_shared<FakeEnvironmentLog>();
  Simulation simulation(compileText(model), {turtle::PlantPlacement{}}, std::make_unique<FakeEnvironment>(log),
                        options);
  ASSERT_FALSE(simulation.rewind());
  while (!simulation.isFinished()) {
    const auto error = simulation.step();
    ASSERT_FALSE(error) << error->message;
  }

  // [ % N... ] B ? E
  const std::uint64_t branch = 4'750'104'241;
  static_assert(branch > std::numeric_limits<std::uint32_t>::max());
  const std::uint64_t query = branch + 5;
  EXPECT_EQ(simulation.string().size(), query + 1);
  EXPECT_EQ(simulation.statistics().modules, query + 1);
  EXPECT_EQ(simulation.statistics().bytes, 2 * (query + 1) + 8);
  EXPECT_EQ(simulation.program().nameOf(simulation.string().types()[query]), "E");
  EXPECT_EQ(simulation.program().nameOf(simulation.string().types()[query - 3]), "]");

  // the environment is asked for the module behind the branch, and its reply gets there
  ASSERT_FALSE(simulation.answer());
  ASSERT_EQ(log->batches.back().size(), 1U);
  EXPECT_EQ(log->batches.back().module[0], query);
  // the seventh pass: 100 * 6
  EXPECT_EQ(simulation.string().parameters()[0], 600.0);
  const auto records = simulation.turtleRecords();
  ASSERT_TRUE(records.has_value());
  const auto& list = *records;
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].module, query);
}

}  // namespace
}  // namespace espalier::simulation::long_string_test
