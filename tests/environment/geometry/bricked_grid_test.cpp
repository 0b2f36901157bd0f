#include "environment/geometry/bricked_grid.h"

#include <gtest/gtest.h>

namespace espalier::environment::bricked_grid_test {
namespace {

TEST(BrickedGrid, IsZeroUntilWrittenAndAfterClear) {
  BrickedGrid<int> grid(20);
  EXPECT_EQ(grid.get(19, 0, 8), 0);
  grid.at(19, 0, 8) = 5;
  grid.at(18, 1, 8) = 6;
  grid.at(0, 0, 0) = 7;
  EXPECT_EQ(grid.get(19, 0, 8), 5);
  EXPECT_EQ(grid.get(18, 1, 8), 6);
  EXPECT_EQ(grid.get(19, 1, 8), 0);
  EXPECT_EQ(grid.usedBrickCount(), 2U);
  grid.clear();
  EXPECT_EQ(grid.get(19, 0, 8), 0);
  grid.at(1, 0, 0) = 1;
  EXPECT_EQ(grid.get(0, 0, 0), 0);
  EXPECT_EQ(grid.usedBrickCount(), 1U);
}

TEST(BrickedGrid, ARunEndsWhereItsBrickOrItsEndIs) {
  BrickedGrid<int> grid(20);
  EXPECT_EQ(grid.run(3, 4, 5, 20).size(), 3U);
  EXPECT_EQ(grid.run(3, 4, 8, 20).size(), 8U);
  EXPECT_EQ(grid.run(3, 4, 8, 10).size(), 2U);
  EXPECT_EQ(grid.run(3, 4, 19, 20).size(), 1U);
  for (std::int64_t z = 2; z < 19;) {
    for (int& cell : grid.run(3, 4, z, 19)) {
      cell = static_cast<int>(z++);
    }
  }
  for (std::int64_t z = 0; z < 20; ++z) {
    EXPECT_EQ(grid.get(3, 4, z), z >= 2 && z < 19 ? z : 0);
    EXPECT_EQ(grid.get(3, 5, z), 0);
  }
}

TEST(BrickedGrid, OutsideReadsAsZero) {
  const BrickedGrid<int> grid(3);
  EXPECT_EQ(grid.get(-1, 0, 0), 0);
  EXPECT_EQ(grid.get(0, 3, 0), 0);
  EXPECT_FALSE(grid.contains(0, 0, 3));
  EXPECT_TRUE(grid.contains(2, 2, 2));
}

}  // namespace
}  // namespace espalier::environment::bricked_grid_test
