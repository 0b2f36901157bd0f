#include "engine/derivation/batch/type_sum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace espalier::type_sum_test {
namespace {

using derivation::TypeSum;

TEST(TypeSum, AddsTheSameWithAndWithoutVectorInstructionsAndModuleByModule) {
  std::mt19937 random(11);
  const auto below = [&random](std::size_t bound) { return static_cast<std::uint32_t>(random() % bound); };
  for (int round = 0; round < 1000; ++round) {
    // one, two and four registers a table, and more types or larger numbers than the vectors take
    const std::size_t typeCount = std::vector<std::size_t>{1, 16, 17, 32, 64, 65, 300}[below(7)];
    const std::size_t bound = std::vector<std::size_t>{1, 2, 256, 257, 100000}[below(5)];
    std::vector<std::uint32_t> numbers(typeCount);
    std::generate(numbers.begin(), numbers.end(), [&] { return below(bound); });
    std::vector<core::ModuleTypeId> types(below(300));
    std::generate(types.begin(), types.end(), [&] { return static_cast<core::ModuleTypeId>(below(typeCount)); });
    std::uint64_t wanted = 0;
    for (const core::ModuleTypeId type : types) {
      wanted += numbers[type];
    }
    const TypeSum sum(numbers);
    EXPECT_EQ(sum.of(types.data(), types.size()), wanted) << "round " << round;
    EXPECT_EQ(sum.ofSlowly(types.data(), types.size()), wanted) << "round " << round;
  }
}

}  // namespace
}  // namespace espalier::type_sum_test
