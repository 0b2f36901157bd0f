#include "environment/geometry/published_raster.h"

namespace espalier::environment {

namespace {

/// ⌊cell · (pixels−1)/(cells−1)⌋, quotient and product in floats.
std::size_t publishedPixel(std::size_t cell, std::size_t cellCount, std::size_t pixelCount) {
  if (cellCount < 2) {
    return 0;
  }
  const float pixelsPerCell = static_cast<float>(pixelCount - 1) / static_cast<float>(cellCount - 1);
  return std::min(static_cast<std::size_t>(static_cast<float>(cell) * pixelsPerCell), pixelCount - 1);
}

}  // namespace

PublishedRaster::PublishedRaster(const Configuration& configuration)
    : shape_(rasterShapeOf(configuration)), maps_(rasterMapsOf(configuration, shape_, publishedPixel)) {}

std::array<float, 2> PublishedRaster::cellsOf(const core::Vec3& point) const {
  const auto flat = shape_.flat(point);
  std::array<float, 2> cells{};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    cells[axis] = (toFloat(flat[axis]) - toFloat(shape_.position[axis])) * static_cast<float>(shape_.cells[axis]) /
                  toFloat(shape_.range[axis]);
  }
  return cells;
}

std::optional<std::size_t> PublishedRaster::cellOf(const core::Vec3& point) const {
  const auto [across, along] = cellsOf(point);
  if (!(across >= 0.0F && along >= 0.0F && across < static_cast<float>(shape_.cells[0]) &&
        along < static_cast<float>(shape_.cells[1]))) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(along) * shape_.cells[0] + static_cast<std::size_t>(across);
}

}  // namespace espalier::environment
