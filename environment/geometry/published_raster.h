#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "environment/geometry/float_vec.h"
#include "environment/geometry/raster.h"

namespace espalier::environment {

/// The raster of the published programs clover, ornament and Meadow: cells in 32-bit floats, the published choice of
/// pixels, and discs whose outermost cells are on the low sides only.
class PublishedRaster {
 public:
  explicit PublishedRaster(const Configuration& configuration);

  [[nodiscard]] const RasterShape& shape() const { return shape_; }
  [[nodiscard]] std::size_t cellCount() const { return shape_.cellCount(); }
  [[nodiscard]] std::size_t cellsInRow() const { return shape_.cells[0]; }
  /// Does what Raster::cellOf does.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;

  /// The cells of a disc, those outside the raster left out. Its half-axes are int(radius in cells + 1) cells a and b.
  /// From the cell of the centre it has the cells −a ≤ i < a, −b ≤ j < b with (i/a)² + (j/b)² ≤ 1. Row by row:
  /// `visit(first, last)`.
  template <typename Visit>
  void forEachRowOfDisc(const core::Vec3& centre, float radius, const Visit& visit) const;
  /// The same cell by cell: `visit(cell)`.
  template <typename Visit>
  void forEachCellOfDisc(const core::Vec3& centre, float radius, const Visit& visit) const {
    forEachRowOfDisc(centre, radius, [&](std::size_t first, std::size_t last) {
      for (std::size_t cell = first; cell <= last; ++cell) {
        visit(cell);
      }
    });
  }

  /// 0 … 255 by cell.
  [[nodiscard]] double lightOf(std::size_t cell) const { return maps_.light[cell]; }
  [[nodiscard]] double secondOf(std::size_t cell) const { return maps_.second[cell]; }

 private:
  /// Across and along, in cells from the low corner.
  [[nodiscard]] std::array<float, 2> cellsOf(const core::Vec3& point) const;

  RasterShape shape_;
  RasterMaps maps_;
};

template <typename Visit>
void PublishedRaster::forEachRowOfDisc(const core::Vec3& centre, float radius, const Visit& visit) const {
  constexpr float kMostCells = 1 << 20;  // far more than a raster has, so that squares of cells fit 64 bits
  const auto middle = cellsOf(centre);
  std::array<std::int64_t, 2> own{};
  std::array<std::int64_t, 2> half{};
  std::array<std::int64_t, 2> first{};
  std::array<std::int64_t, 2> last{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const float cells = static_cast<float>(shape_.cells[axis]);
    const float size = radius * cells / toFloat(shape_.range[axis]) + 1.0F;
    half[axis] = static_cast<std::int64_t>(std::clamp(size, -kMostCells, kMostCells));
    own[axis] = static_cast<std::int64_t>(std::floor(std::clamp(middle[axis], -2.0F * kMostCells, 2.0F * kMostCells)));
    first[axis] = std::max(own[axis] - half[axis], std::int64_t{0});
    last[axis] = std::min(own[axis] + half[axis], static_cast<std::int64_t>(shape_.cells[axis])) - 1;
  }
  // whole numbers decide (i/a)² + (j/b)² ≤ 1 without rounding
  const double aa = static_cast<double>(half[0] * half[0]);
  const double bb = static_cast<double>(half[1] * half[1]);
  for (std::int64_t y = first[1]; y <= last[1]; ++y) {
    const double jj = static_cast<double>((y - own[1]) * (y - own[1]));
    const auto isInside = [&](std::int64_t x) {
      const double ii = static_cast<double>((x - own[0]) * (x - own[0]));
      return ii * bb + jj * aa <= aa * bb;
    };
    std::int64_t low = first[0];
    std::int64_t high = last[0];
    while (low <= high && !isInside(low)) {
      ++low;
    }
    while (low <= high && !isInside(high)) {
      --high;
    }
    if (low <= high) {
      const std::size_t row = static_cast<std::size_t>(y) * shape_.cells[0];
      visit(row + static_cast<std::size_t>(low), row + static_cast<std::size_t>(high));
    }
  }
}

}  // namespace espalier::environment
