#include "environment/geometry/spatial_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

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
  std::vector<std::pair<CellIndex, std::uint32_t>> sorted(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    sorted[i] = {cellOf(points[i]), static_cast<std::uint32_t>(i)};
  }
  std::sort(sorted.begin(), sorted.end());
  members_.reserve(sorted.size());
  for (const auto& [cell, point] : sorted) {
    if (cells_.empty() || cells_.back() != cell) {
      cells_.push_back(cell);
      begins_.push_back(members_.size());
    }
    members_.push_back(point);
  }
  begins_.push_back(members_.size());
}

CellIndex SpatialCells::cellOf(const core::Vec3& point) const {
  return {cellCoordinate(point.x, cellSize_), cellCoordinate(point.y, cellSize_), cellCoordinate(point.z, cellSize_)};
}

CellSweep::CellSweep(const SpatialCells& cells, const CellIndex& reach) : cells_(&cells), reachZ_(reach.z) {
  for (std::int64_t x = -reach.x; x <= reach.x; ++x) {
    for (std::int64_t y = -reach.y; y <= reach.y; ++y) {
      rows_.push_back({x, y, 0});
    }
  }
  // near rows first: a test that holds there ends the search early
  std::stable_sort(rows_.begin(), rows_.end(),
                   [](const Row& a, const Row& b) { return a.x * a.x + a.y * a.y < b.x * b.x + b.y * b.y; });
}

void CellSweep::moveTo(std::size_t number) {
  ESPALIER_CHECK(number >= current_);
  current_ = number;
  const CellIndex& centre = cells_->cell(number);
  for (Row& row : rows_) {
    const CellIndex first{centre.x + row.x, centre.y + row.y, centre.z - reachZ_};
    while (row.next < cells_->cellCount() && cells_->cell(row.next) < first) {
      ++row.next;
    }
  }
}

}  // namespace espalier::environment
