#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/base/configuration.h"
#include "environment/base/process_entry.h"
#include "environment/geometry/box_tree.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

/// Where a raster lies: a rectangle of cells in a plane of the world.
struct RasterShape {
  Plane plane = Plane::Xy;
  std::array<double, 2> position{};  // low corner, across and along
  std::array<double, 2> range{};     // size, length units
  std::array<std::size_t, 2> cells{1, 1};

  [[nodiscard]] std::size_t cellCount() const { return cells[0] * cells[1]; }
  /// About how many cells a disc of an area has.
  [[nodiscard]] double cellsOfArea(double area) const {
    const auto all = static_cast<double>(cellCount());
    return std::min(all, all * area / (range[0] * range[1]));
  }
  /// The space over the raster.
  [[nodiscard]] Bounds box() const;
  /// The coordinates of a point across and along.
  [[nodiscard]] std::array<double, 2> flat(const core::Vec3& point) const {
    return {plane == Plane::Yz ? point.y : point.x, plane == Plane::Xy ? point.y : point.z};
  }
};

/// Reads the keys below.
[[nodiscard]] RasterShape rasterShapeOf(const Configuration& configuration);
/// A map whose rows differ in length. Empty: none.
[[nodiscard]] std::vector<core::Diagnostic> problemsOfRaster(std::string_view process,
                                                             const Configuration& configuration);

/// Two maps of bytes over a raster, by cell, from the low corner row by row.
struct RasterMaps {
  std::vector<double> light;   // (cellCount)
  std::vector<double> second;  // (cellCount)
};

/// Which pixel of `pixelCount` the cell `cell` of `cellCount` shows, both counted from the low side.
using PixelOfCell = std::size_t (*)(std::size_t cell, std::size_t cellCount, std::size_t pixelCount);
[[nodiscard]] RasterMaps rasterMapsOf(const Configuration& configuration, const RasterShape& shape,
                                      PixelOfCell pixelOfCell);

/// The raster of the processes `clover`, `ornament` and `meadow`. Maps of another size are enlarged or reduced by
/// taking the pixel over the cell's low corner.
class Raster {
 public:
  explicit Raster(const Configuration& configuration);

  [[nodiscard]] const RasterShape& shape() const { return shape_; }
  [[nodiscard]] std::size_t cellCount() const { return shape_.cellCount(); }
  [[nodiscard]] std::size_t cellsInRow() const { return shape_.cells[0]; }
  /// The cell that a point lies over, counted from the low corner row by row; nothing outside. Low borders belong to
  /// the raster, high ones do not.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;

  /// The cells whose middle is within the radius of a point, those outside the raster left out, row by row:
  /// `visit(first, last)`. O(rows of the disc + its border).
  template <typename Visit>
  void forEachRowOfDisc(const core::Vec3& centre, double radius, const Visit& visit) const;
  /// The same cell by cell: `visit(cell)`.
  template <typename Visit>
  void forEachCellOfDisc(const core::Vec3& centre, double radius, const Visit& visit) const {
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
  [[nodiscard]] std::array<double, 2> cellsOf(const core::Vec3& point) const;

  RasterShape shape_;
  RasterMaps maps_;
};

inline constexpr std::array kRasterRange{2.0, 2.0};
inline constexpr std::array kRasterPosition{-1.0, -1.0};
inline constexpr std::array kRasterSize{512.0, 512.0};

inline constexpr ConfigurationKey kRasterSizeKey{.name = "gridSize",
                                                 .kind = KeyKind::Numbers,
                                                 .description = "number of cells across and along the raster",
                                                 .minimum = 1.0,
                                                 .maximum = 8192.0,
                                                 .isWhole = true,
                                                 .defaultNumbers = kRasterSize,
                                                 .minimumCount = 2,
                                                 .maximumCount = 2};
inline constexpr ConfigurationKey kRasterRangeKey{.name = "range",
                                                  .kind = KeyKind::Numbers,
                                                  .description = "size of the raster across and along",
                                                  .unit = "length",
                                                  .minimum = 0.0,
                                                  .isMinimumExclusive = true,
                                                  .defaultNumbers = kRasterRange,
                                                  .minimumCount = 2,
                                                  .maximumCount = 2};
inline constexpr ConfigurationKey kRasterPositionKey{
    .name = "position",
    .kind = KeyKind::Numbers,
    .description = "corner of the raster with the smallest coordinates",
    .unit = "length",
    .defaultNumbers = kRasterPosition,
    .minimumCount = 2,
    .maximumCount = 2};
inline constexpr ConfigurationKey kRasterPlaneKey{
    .name = "plane",
    .kind = KeyKind::Choice,
    .description = "the plane of the raster: xy when z is up, xz when y is up",
    .defaultText = "xy",
    .choices = kPlaneNames};
inline constexpr ConfigurationKey kRasterLightKey{
    .name = "lightMap",
    .kind = KeyKind::Rows,
    .description = "light from above, 0 to 255, by rows from the far edge to the near one; empty: 255 everywhere",
    .minimum = 0.0,
    .maximum = 255.0,
    .minimumCount = 1};
inline constexpr ConfigurationKey kRasterSecondKey{
    .name = "secondMap",
    .kind = KeyKind::Rows,
    .description = "a second value, 0 to 255, laid out as lightMap; empty: 0 everywhere",
    .minimum = 0.0,
    .maximum = 255.0,
    .minimumCount = 1};

/// All of them: the keys of a process on a raster.
inline constexpr std::array kRasterKeys{kRasterSizeKey,  kRasterRangeKey, kRasterPositionKey,
                                        kRasterPlaneKey, kRasterLightKey, kRasterSecondKey};

/// `input image: FILE` (green: lightMap, red: secondMap) and `z is up: yes|no` of the specification.
[[nodiscard]] std::string readInputImage(const PublishedLineInput& input);
[[nodiscard]] std::string readUpAxis(const PublishedLineInput& input);

inline constexpr PublishedKeyword kRasterSizeKeyword{
    .keyword = "grid size", .kind = PublishedKind::Numbers, .key = "gridSize", .count = 2};
inline constexpr PublishedKeyword kRasterRangeKeyword{
    .keyword = "grid range", .kind = PublishedKind::Numbers, .key = "range", .count = 2};
inline constexpr PublishedKeyword kRasterPositionKeyword{
    .keyword = "grid position", .kind = PublishedKind::Numbers, .key = "position", .count = 2};
inline constexpr PublishedKeyword kRasterImageKeyword{
    .keyword = "input image", .kind = PublishedKind::Own, .key = {}, .read = readInputImage};
inline constexpr PublishedKeyword kRasterUpKeyword{
    .keyword = "z is up", .kind = PublishedKind::Own, .key = {}, .read = readUpAxis};

inline constexpr std::array kRasterKeywords{kRasterSizeKeyword, kRasterRangeKeyword, kRasterPositionKeyword,
                                            kRasterImageKeyword, kRasterUpKeyword};

template <typename Visit>
void Raster::forEachRowOfDisc(const core::Vec3& centre, double radius, const Visit& visit) const {
  const auto [across, along] = cellsOf(centre);
  // half-axes in cells
  const double a = radius * static_cast<double>(shape_.cells[0]) / shape_.range[0];
  const double b = radius * static_cast<double>(shape_.cells[1]) / shape_.range[1];
  const double x0 = across - 0.5;
  const double y0 = along - 0.5;
  const double lastX = static_cast<double>(shape_.cells[0] - 1);
  const double lastY = static_cast<double>(shape_.cells[1] - 1);
  for (double y = std::max(std::ceil(y0 - b), 0.0); y <= std::min(std::floor(y0 + b), lastY); y += 1.0) {
    const double dy = b > 0.0 ? (y - y0) / b : 0.0;
    const auto isInside = [&](double x) {
      const double dx = a > 0.0 ? (x - x0) / a : 0.0;
      return dx * dx + dy * dy <= 1.0;
    };
    // rounding is monotone, so the cells of a row have no gap
    double first = std::max(std::ceil(x0 - a), 0.0);
    double last = std::min(std::floor(x0 + a), lastX);
    while (first <= last && !isInside(first)) {
      first += 1.0;
    }
    while (first <= last && !isInside(last)) {
      last -= 1.0;
    }
    if (first <= last) {
      const std::size_t row = static_cast<std::size_t>(y) * shape_.cells[0];
      visit(row + static_cast<std::size_t>(first), row + static_cast<std::size_t>(last));
    }
  }
}

}  // namespace espalier::environment
