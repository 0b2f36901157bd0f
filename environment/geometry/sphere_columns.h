#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/geometry/sphere_tree.h"

namespace espalier::environment {

/// Spheres before many rays of one direction: a grid in the plane across them, in whose cells stand the spheres that a
/// ray through the cell may meet. When every sphere sends such a ray, that is faster than a tree, which each ray walks
/// down anew.
class SphereColumns {
 public:
  /// `direction` is a unit vector. `margin` enlarges all spheres. O(n + cells that the spheres cover).
  SphereColumns(std::span<const Sphere> spheres, const core::Vec3& direction, double margin);

  /// False when the spheres differ so much in size, or are so far away, that a grid would be too large: take a tree.
  [[nodiscard]] bool isMade() const { return isMade_; }

  /// Calls `visit(index, sphere)` until it returns false: for every sphere that the line through `place` meets, on both
  /// sides of the place, and for some beside it. They come in ascending order.
  template <typename Visit>
  void visit(const core::Vec3& place, const Visit& visit) const {
    const double u = core::dot(place, across_) - lowU_;
    const double v = core::dot(place, up_) - lowV_;
    if (!(u >= 0.0 && v >= 0.0)) {
      return;
    }
    const double column = u / side_;
    const double row = v / side_;
    if (!(column < static_cast<double>(columns_) && row < static_cast<double>(rows_))) {
      return;
    }
    const std::size_t cell = static_cast<std::size_t>(row) * columns_ + static_cast<std::size_t>(column);
    for (std::uint32_t k = begin_[cell]; k < begin_[cell + 1]; ++k) {
      if (!visit(entries_[k], spheres_[entries_[k]])) {
        return;
      }
    }
  }

 private:
  std::span<const Sphere> spheres_;
  core::Vec3 across_, up_;  // unit vectors of the plane
  double lowU_ = 0.0;       // of the grid, along these
  double lowV_ = 0.0;
  double side_ = 1.0;  // of a cell
  std::size_t columns_ = 0;
  std::size_t rows_ = 0;
  std::vector<std::uint32_t> begin_;    // of the entries of each cell, and their end
  std::vector<std::uint32_t> entries_;  // indices of spheres, cell by cell
  bool isMade_ = false;
};

}  // namespace espalier::environment
