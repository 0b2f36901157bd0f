#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/geometry/shapes.h"

namespace espalier::environment {

/// Points of space that are taken away one after the other, in a grid of cells. A search costs the cells of its box and
/// the points in them that are left.
class MarkerGrid {
 public:
  struct Marker {
    core::Vec3 place;
    std::uint32_t number = 0;  // the caller's
    std::uint32_t rank = 0;    // the caller's
  };

  MarkerGrid() = default;
  /// `reach`: the usual radius of searches, above 0. O(markers).
  MarkerGrid(std::span<const Marker> markers, double reach);

  /// The markers that are left, by slot.
  [[nodiscard]] std::span<const Marker> markers() const { return markers_; }
  /// Calls `visit(slot)` for the markers of all cells that a box meets, at least those in the box.
  template <typename Visit>
  void visitBox(const Bounds& box, const Visit& visit) const {
    if (markers_.empty()) {
      return;
    }
    const Cell low = cellOf(box.low);
    const Cell high = cellOf(box.high);
    for (std::size_t x = low[0]; x <= high[0]; ++x) {
      for (std::size_t y = low[1]; y <= high[1]; ++y) {
        // the cells of a row and their markers lie one after the other
        const std::size_t row = (x * counts_[1] + y) * counts_[2];
        for (std::size_t slot = begins_[row + low[2]]; slot < begins_[row + high[2] + 1]; ++slot) {
          visit(slot);
        }
      }
    }
  }
  /// Removes the markers of which `isLeft(marker)` is false. Slots change. O(markers), needs no memory.
  template <typename IsLeft>
  void keep(const IsLeft& isLeft) {
    std::size_t next = 0;
    std::size_t slot = 0;
    for (std::size_t cell = 0; cell + 1 < begins_.size(); ++cell) {
      begins_[cell] = next;
      for (const std::size_t end = begins_[cell + 1]; slot < end; ++slot) {
        if (isLeft(markers_[slot])) {
          markers_[next++] = markers_[slot];
        }
      }
    }
    if (!begins_.empty()) {
      begins_.back() = next;
    }
    markers_.resize(next);
  }

 private:
  using Cell = std::array<std::size_t, 3>;
  [[nodiscard]] Cell cellOf(const core::Vec3& place) const;

  core::Vec3 low_;
  double size_ = 1.0;                // of a cell
  Cell counts_{1, 1, 1};             // of the cells along x, y and z
  std::vector<Marker> markers_;      // by cell: x, then y, then z
  std::vector<std::size_t> begins_;  // first marker by cell (cells + 1)
};

/// A box around the part of a ball that lies in the cone around a direction. `cosine`: of half the cone's angle; below
/// -1: the whole ball. A direction that has not the length 1 gives the box of the ball.
[[nodiscard]] Bounds boxOfCone(const core::Vec3& apex, const core::Vec3& direction, double radius, double cosine);

}  // namespace espalier::environment
