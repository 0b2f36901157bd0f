#include "engine/derivation/parallel/shared_output.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

namespace espalier::derivation::shared_output_test {
namespace {

TEST(SharedOutput, HoldsWhatIsReserved) {
  ModuleString string;
  string.typeBuffer().reserve(1000);
  string.parameterBuffer().reserve(500);
  const SharedOutput output(string);
  const std::uint64_t modules = string.typeBuffer().capacity();
  const std::uint64_t parameters = string.parameterBuffer().capacity();
  EXPECT_TRUE(output.holds(modules, parameters));
  EXPECT_FALSE(output.holds(modules + 1, parameters));
  EXPECT_FALSE(output.holds(modules, parameters + 1));
}

TEST(SharedOutput, ThreadsWriteBehindWhatIsThere) {
  constexpr std::uint64_t kPart = 300000;  // more than a huge page of parameters
  ModuleString string;
  const double first = 0.5;
  string.append(1, {&first, 1});
  string.typeBuffer().reserve(1 + 2 * kPart);
  string.parameterBuffer().reserve(1 + 2 * kPart);
  SharedOutput output(string);
  {
    std::vector<std::jthread> threads;
    for (std::uint64_t part = 0; part < 2; ++part) {
      threads.emplace_back([&output, part] {
        const std::uint64_t begin = 1 + part * kPart;
        output.prepare(begin, begin + kPart, begin, begin + kPart);
        std::fill_n(output.types() + begin, kPart, static_cast<core::ModuleTypeId>(part + 2));
        std::fill_n(output.parameters() + begin, kPart, static_cast<double>(part));
      });
    }
  }
  output.finish(1 + 2 * kPart, 1 + 2 * kPart);
  ASSERT_EQ(string.size(), 1 + 2 * kPart);
  ASSERT_EQ(string.parameterCount(), 1 + 2 * kPart);
  EXPECT_EQ(string.types()[0], 1);
  EXPECT_EQ(string.parameters()[0], 0.5);
  EXPECT_EQ(std::count(string.types().begin(), string.types().end(), 2), static_cast<std::ptrdiff_t>(kPart));
  EXPECT_EQ(std::count(string.types().begin(), string.types().end(), 3), static_cast<std::ptrdiff_t>(kPart));
  EXPECT_EQ(string.parameters()[2 * kPart], 1.0);
}

}  // namespace
}  // namespace espalier::derivation::shared_output_test
