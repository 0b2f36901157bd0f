#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A cube of space with integer coordinates; ordered by x, then y, then z.
struct CellIndex {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;

  constexpr auto operator<=>(const CellIndex&) const = default;
};

/// Points sorted into cubic cells of one size. Only occupied cells exist, so the extent of the points costs nothing.
/// Building is O(n log n).
class SpatialCells {
 public:
  /// `cellSize` > 0. Coordinates beyond 2^61 cells share the outermost cells.
  SpatialCells(std::span<const core::Vec3> points, double cellSize);

  [[nodiscard]] CellIndex cellOf(const core::Vec3& point) const;
  /// Occupied cells are numbered 0..cellCount()-1 in ascending order.
  [[nodiscard]] std::size_t cellCount() const { return cells_.size(); }
  [[nodiscard]] const CellIndex& cell(std::size_t number) const { return cells_[number]; }
  /// Indices of the points in a cell, ascending unless reordered through members().
  [[nodiscard]] std::span<const std::uint32_t> pointsIn(std::size_t number) const {
    return {members_.data() + begins_[number], begins_[number + 1] - begins_[number]};
  }
  [[nodiscard]] std::span<std::uint32_t> members(std::size_t number) {
    return {members_.data() + begins_[number], begins_[number + 1] - begins_[number]};
  }

 private:
  double cellSize_;
  std::vector<CellIndex> cells_;        // ascending (cellCount)
  std::vector<std::size_t> begins_;     // first entry of members_ by cell (cellCount + 1)
  std::vector<std::uint32_t> members_;  // point indices, grouped by cell (points)
};

/// Finds the occupied neighbours of the cells in ascending order. Every row of neighbours (the same x and y) has a
/// pointer that only moves forward, so a whole pass is O(rows * cells) and reads memory in order.
class CellSweep {
 public:
  /// Neighbours are the cells at most `reach` away in each coordinate. `cells` must outlive the sweep.
  CellSweep(const SpatialCells& cells, const CellIndex& reach);

  /// Goes to a cell; its number must not be smaller than the one before.
  void moveTo(std::size_t number);
  /// Whether `test(neighbour)` holds for a neighbour of the current cell, the cell itself left out.
  template <typename Test>
  [[nodiscard]] bool anyNeighbour(const Test& test) const {
    const CellIndex& centre = cells_->cell(current_);
    for (const Row& row : rows_) {
      const CellIndex last{centre.x + row.x, centre.y + row.y, centre.z + reachZ_};
      for (std::size_t number = row.next; number < cells_->cellCount() && cells_->cell(number) <= last; ++number) {
        if (number != current_ && test(number)) {
          return true;
        }
      }
    }
    return false;
  }

 private:
  struct Row {
    std::int64_t x;  // offset from the current cell
    std::int64_t y;
    std::size_t next;  // the first occupied cell not before the row's beginning
  };

  const SpatialCells* cells_;
  std::int64_t reachZ_;
  std::vector<Row> rows_;  // nearest first
  std::size_t current_ = 0;
};

}  // namespace espalier::environment
