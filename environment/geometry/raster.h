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
#include "environment/geometry/plane.h"

namespace espalier::environment {

/// A rectangle of cells in a plane of the world, with two maps of bytes over it: the processes `clover` and `ornament`.
class Raster {
 public:
  /// Reads the keys below. Maps of another size are enlarged or reduced by taking the nearest value.
  explicit Raster(const Configuration& configuration);
  /// A map whose rows differ in length. Empty: none.
  [[nodiscard]] static std::vector<core::Diagnostic> problemsOf(std::string_view process,
                                                                const Configuration& configuration);

  [[nodiscard]] std::size_t cellCount() const { return columnCount_ * rowCount_; }
  /// The cell that a point lies over, counted from the low corner row by row; nothing outside. Low borders belong to
  /// the raster, high ones do not.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;

  /// The cells of a disc around a point, those outside the raster left out. With `isPublished` it is the published
  /// program's ellipse of int(radius in cells + 1) cells to each side of the point's cell; otherwise all cells whose
  /// middle is within the radius of the point. `visit(cell)`. O(cells of the disc).
  template <typename Visit>
  void forEachCellOfDisc(const core::Vec3& centre, double radius, bool isPublished, const Visit& visit) const;

  /// 0 … 255 by cell.
  [[nodiscard]] double lightOf(std::size_t cell) const { return light_[cell]; }
  [[nodiscard]] double secondOf(std::size_t cell) const { return second_[cell]; }

 private:
  struct Flat {
    double across = 0.0;  // along the rows, in cells from the low corner
    double along = 0.0;
  };
  [[nodiscard]] Flat cellsOf(const core::Vec3& point) const;

  Plane plane_;
  std::array<double, 2> position_;  // low corner
  std::array<double, 2> range_;     // size, length units
  std::size_t columnCount_;
  std::size_t rowCount_;
  std::vector<double> light_;   // (rowCount, columnCount)
  std::vector<double> second_;  // (rowCount, columnCount)
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
void Raster::forEachCellOfDisc(const core::Vec3& centre, double radius, bool isPublished, const Visit& visit) const {
  const Flat middle = cellsOf(centre);
  // half-axes in cells
  double a = radius * static_cast<double>(columnCount_) / range_[0];
  double b = radius * static_cast<double>(rowCount_) / range_[1];
  double x0 = middle.across - 0.5;
  double y0 = middle.along - 0.5;
  if (isPublished) {
    a = std::trunc(a + 1.0);
    b = std::trunc(b + 1.0);
    x0 = std::floor(middle.across);
    y0 = std::floor(middle.along);
  }
  const double lastX = static_cast<double>(columnCount_ - 1);
  const double lastY = static_cast<double>(rowCount_ - 1);
  for (double y = std::max(std::ceil(y0 - b), 0.0); y <= std::min(std::floor(y0 + b), lastY); y += 1.0) {
    for (double x = std::max(std::ceil(x0 - a), 0.0); x <= std::min(std::floor(x0 + a), lastX); x += 1.0) {
      const double dx = a > 0.0 ? (x - x0) / a : 0.0;
      const double dy = b > 0.0 ? (y - y0) / b : 0.0;
      if (dx * dx + dy * dy <= 1.0) {
        visit(static_cast<std::size_t>(y) * columnCount_ + static_cast<std::size_t>(x));
      }
    }
  }
}

}  // namespace espalier::environment
