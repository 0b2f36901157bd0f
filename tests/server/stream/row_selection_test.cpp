#include "server/stream/row_selection.h"

#include <gtest/gtest.h>

#include <numeric>

namespace espalier::server::row_selection_test {
namespace {

const std::vector<std::string> kSymbols{"A", "F", "+"};

TEST(RowSelection, TakesAllWithoutNames) {
  const RowSelection all(kSymbols, {});
  EXPECT_TRUE(all.takes(7, 2));
}

TEST(RowSelection, TakesPlantsAndSymbolsThatItNames) {
  const RowSelection some(kSymbols, {.symbols = {"F", "none"}, .plants = {3, 1}});
  EXPECT_TRUE(some.takes(1, 1));
  EXPECT_TRUE(some.takes(3, 1));
  EXPECT_FALSE(some.takes(2, 1));
  EXPECT_FALSE(some.takes(1, 0));
  EXPECT_FALSE(some.takes(1, 99));
}

TEST(RowSelection, LongListsDoNotMakeRowsSlow) {
  protocol::StreamSelection select;
  select.plants.resize(1'000'000);
  std::iota(select.plants.rbegin(), select.plants.rend(), 1U);
  const RowSelection selection(kSymbols, select);
  // with a look at each name this would be 10^12 comparisons, hours
  std::uint32_t taken = 0;
  for (std::uint32_t row = 0; row < 1'000'000; ++row) {
    taken += selection.takes(row, 0) ? 1 : 0;
  }
  EXPECT_EQ(taken, 999'999U);
}

}  // namespace
}  // namespace espalier::server::row_selection_test
