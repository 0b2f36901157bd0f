#include "environment/geometry/spatial_cells.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <random>
#include <set>

namespace espalier::environment::spatial_cells_test {
namespace {

TEST(SpatialCells, EveryPointIsInItsCellOnce) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-10, 10);
  std::vector<core::Vec3> points;
  for (int i = 0; i < 1000; ++i) {
    points.push_back({place(random), place(random), place(random)});
  }
  const SpatialCells cells(points, 2.5);
  std::vector<int> seen(points.size(), 0);
  for (std::size_t number = 0; number < cells.cellCount(); ++number) {
    EXPECT_TRUE(number == 0 || cells.cell(number - 1) < cells.cell(number));
    for (const std::uint32_t point : cells.pointsIn(number)) {
      EXPECT_EQ(cells.cellOf(points[point]), cells.cell(number));
      ++seen[point];
    }
  }
  EXPECT_EQ(seen, std::vector<int>(points.size(), 1));
}

TEST(SpatialCells, NegativeCoordinatesRoundDown) {
  const std::array<core::Vec3, 1> points{core::Vec3{-0.1, 2.0, 0.0}};
  const SpatialCells cells(points, 1.0);
  EXPECT_EQ(cells.cellOf(points[0]), (CellIndex{-1, 2, 0}));
}

TEST(CellSweep, FindsExactlyTheOccupiedCellsWithinReach) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> place(0, 8);
  std::vector<core::Vec3> points;
  for (int i = 0; i < 200; ++i) {
    points.push_back({place(random), place(random), place(random)});
  }
  const SpatialCells cells(points, 1.0);
  for (const CellIndex& reach : {CellIndex{2, 2, 2}, CellIndex{2, 0, 1}, CellIndex{0, 1, 0}}) {
    CellSweep sweep(cells, reach);
    for (std::size_t number = 0; number < cells.cellCount(); number += 1 + number % 3) {
      sweep.moveTo(number);
      std::set<std::size_t> found;
      EXPECT_FALSE(sweep.anyNeighbour([&](std::size_t neighbour) { return !found.insert(neighbour).second; }));
      std::set<std::size_t> expected;
      for (std::size_t other = 0; other < cells.cellCount(); ++other) {
        const CellIndex& a = cells.cell(number);
        const CellIndex& b = cells.cell(other);
        if (other != number && std::abs(a.x - b.x) <= reach.x && std::abs(a.y - b.y) <= reach.y &&
            std::abs(a.z - b.z) <= reach.z) {
          expected.insert(other);
        }
      }
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(SpatialCells, NoPointsMakeNoCells) {
  EXPECT_EQ(SpatialCells({}, 1.0).cellCount(), 0U);
}

}  // namespace
}  // namespace espalier::environment::spatial_cells_test
