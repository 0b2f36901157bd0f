#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A cube of space with integer coordinates.
struct CellIndex {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;

  constexpr bool operator==(const CellIndex&) const = default;
};

/// Points sorted into cubic cells of one size, found by a hash of the cell's integer coordinates, so that the extent of
/// the points costs nothing. Building is O(points); a look-up is O(1).
class SpatialCells {
 public:
  /// `cellSize` > 0. Coordinates beyond 2^61 cells share the outermost cells.
  SpatialCells(std::span<const core::Vec3> points, double cellSize);

  [[nodiscard]] CellIndex cellOf(const core::Vec3& point) const;
  /// Numbers of the occupied cells are 0..cellCount()-1 in the order of their first point.
  [[nodiscard]] std::size_t cellCount() const { return cells_.size(); }
  [[nodiscard]] const CellIndex& cell(std::size_t number) const { return cells_[number]; }
  /// The number of an occupied cell, or kNone.
  [[nodiscard]] std::size_t find(const CellIndex& cell) const;
  /// Indices of the points in a cell, ascending unless reordered through members().
  [[nodiscard]] std::span<const std::uint32_t> pointsIn(std::size_t number) const {
    return {members_.data() + begins_[number], begins_[number + 1] - begins_[number]};
  }
  [[nodiscard]] std::span<std::uint32_t> members(std::size_t number) {
    return {members_.data() + begins_[number], begins_[number + 1] - begins_[number]};
  }

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

 private:
  [[nodiscard]] std::size_t slotOf(const CellIndex& cell) const;

  double cellSize_;
  std::vector<std::uint32_t> slots_;    // cell number + 1 by hash slot, 0: free (power of two, at most half full)
  std::vector<CellIndex> cells_;        // (cellCount)
  std::vector<std::size_t> begins_;     // first entry of members_ by cell (cellCount + 1)
  std::vector<std::uint32_t> members_;  // point indices, grouped by cell (points)
};

}  // namespace espalier::environment
