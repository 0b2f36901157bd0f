#include "environment/spatial_cells.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <random>
#include <set>

#include "environment/bricked_grid.h"
#include "environment/state_bytes.h"

namespace espalier::environment {
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

TEST(BrickedGrid, OutsideReadsAsZero) {
  const BrickedGrid<int> grid(3);
  EXPECT_EQ(grid.get(-1, 0, 0), 0);
  EXPECT_EQ(grid.get(0, 3, 0), 0);
  EXPECT_FALSE(grid.contains(0, 0, 3));
  EXPECT_TRUE(grid.contains(2, 2, 2));
}

TEST(StateBytes, ReadBackWhatWasWritten) {
  StateWriter writer;
  writer.integer(7);
  writer.number(-0.1);
  writer.text("abc");
  const std::string bytes = writer.take();
  StateReader reader(bytes);
  EXPECT_EQ(reader.integer(), 7U);
  EXPECT_EQ(reader.number(), -0.1);
  EXPECT_EQ(reader.text(), "abc");
  EXPECT_TRUE(reader.isComplete());
}

TEST(StateBytes, CutOffStateIsNoticed) {
  StateWriter writer;
  writer.text("abc");
  const std::string bytes = writer.take();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    StateReader reader(std::string_view(bytes).substr(0, size));
    EXPECT_EQ(reader.text(), "");
    EXPECT_FALSE(reader.isIntact()) << size;
  }
}

}  // namespace
}  // namespace espalier::environment
