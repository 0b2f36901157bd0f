#include "environment/spatial_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/core/check.h"

namespace espalier::environment {

namespace {

std::int64_t cellCoordinate(double value, double cellSize) {
  constexpr double kBound = 2305843009213693952.0;  // 2^61
  const double cell = std::floor(value / cellSize);
  return static_cast<std::int64_t>(std::clamp(cell, -kBound, kBound));
}

}  // namespace

SpatialCells::SpatialCells(std::span<const core::Vec3> points, double cellSize) : cellSize_(cellSize) {
  ESPALIER_CHECK(cellSize > 0.0);
  ESPALIER_CHECK(points.size() < 0xFFFFFFFFU);
  slots_.assign(std::bit_ceil(2 * points.size() + 2), 0);

  // number the occupied cells and count their points
  std::vector<std::uint32_t> cellOfPoint(points.size());
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const CellIndex cell = cellOf(points[i]);
    std::uint32_t& slot = slots_[slotOf(cell)];
    if (slot == 0) {
      cells_.push_back(cell);
      counts.push_back(0);
      slot = static_cast<std::uint32_t>(cells_.size());
    }
    cellOfPoint[i] = slot - 1;
    ++counts[slot - 1];
  }

  // group the points by cell
  begins_.assign(cells_.size() + 1, 0);
  for (std::size_t number = 0; number < cells_.size(); ++number) {
    begins_[number + 1] = begins_[number] + counts[number];
  }
  members_.resize(points.size());
  std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    members_[next[cellOfPoint[i]]++] = static_cast<std::uint32_t>(i);
  }
}

CellIndex SpatialCells::cellOf(const core::Vec3& point) const {
  return {cellCoordinate(point.x, cellSize_), cellCoordinate(point.y, cellSize_), cellCoordinate(point.z, cellSize_)};
}

std::size_t SpatialCells::find(const CellIndex& cell) const {
  const std::uint32_t slot = slots_[slotOf(cell)];
  return slot == 0 ? kNone : slot - 1;
}

std::size_t SpatialCells::slotOf(const CellIndex& cell) const {
  // three odd multipliers and a final mix spread neighbouring cells over the table
  std::uint64_t hash = static_cast<std::uint64_t>(cell.x) * 0x9E3779B97F4A7C15ULL;
  hash ^= std::rotl(static_cast<std::uint64_t>(cell.y) * 0xC2B2AE3D27D4EB4FULL, 21);
  hash ^= std::rotl(static_cast<std::uint64_t>(cell.z) * 0x165667B19E3779F9ULL, 42);
  hash = (hash ^ (hash >> 32U)) * 0xD6E8FEB86659FD93ULL;
  hash ^= hash >> 32U;
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = static_cast<std::size_t>(hash) & mask;
  while (slots_[slot] != 0 && !(cells_[slots_[slot] - 1] == cell)) {
    slot = (slot + 1) & mask;
  }
  return slot;
}

}  // namespace espalier::environment
