#include "environment/geometry/sphere_columns.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace espalier::environment {

using core::Vec3;

namespace {

constexpr double kCellsOfSphere = 4.0;            // at most so many cells for each sphere, and some for the rims
constexpr std::size_t kMostEntriesOfSphere = 64;  // on the average
constexpr double kRounding = 1e-12;               // of places, relative to the largest coordinate

/// A sphere in the plane: the cells that its shadow covers.
struct Shadow {
  std::size_t left, right, low, high;  // inclusive
};

Vec3 columnsAcross(const Vec3& direction) {
  // the axis that the direction has least of
  const Vec3 size{std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)};
  const bool isX = size.x <= size.y && size.x <= size.z;
  const bool isY = !isX && size.y <= size.z;
  const Vec3 axis{isX ? 1.0 : 0.0, isY ? 1.0 : 0.0, isX || isY ? 0.0 : 1.0};
  return core::normalised(core::cross(direction, axis));
}

}  // namespace

SphereColumns::SphereColumns(std::span<const Sphere> spheres, const Vec3& direction, double margin)
    : spheres_(spheres), across_(columnsAcross(direction)), up_(core::cross(direction, across_)) {
  if (spheres.empty()) {
    return;
  }
  double largest = 0.0;
  double radii = 0.0;
  for (const Sphere& sphere : spheres) {
    largest = std::max(
        {largest, std::abs(sphere.centre.x), std::abs(sphere.centre.y), std::abs(sphere.centre.z), sphere.radius});
    radii += sphere.radius + margin;
  }
  const double rounding = kRounding * (largest + margin);
  double highU = -HUGE_VAL;
  double highV = -HUGE_VAL;
  lowU_ = HUGE_VAL;
  lowV_ = HUGE_VAL;
  for (const Sphere& sphere : spheres) {
    const double reach = sphere.radius + margin + rounding;
    const double u = core::dot(sphere.centre, across_);
    const double v = core::dot(sphere.centre, up_);
    lowU_ = std::min(lowU_, u - reach);
    lowV_ = std::min(lowV_, v - reach);
    highU = std::max(highU, u + reach);
    highV = std::max(highV, v + reach);
  }
  const double width = highU - lowU_;
  const double height = highV - lowV_;
  // a coordinate that is no number makes no comparison true
  if (!(width * height < 1e200) || !(largest < 1e100) || !(width > 0.0) || !(height > 0.0)) {
    return;
  }
  const auto count = static_cast<double>(spheres.size());
  side_ = std::max({radii / count + rounding, std::sqrt(width * height / (kCellsOfSphere * count)),
                    std::max(width, height) / (kCellsOfSphere * count)});
  columns_ = static_cast<std::size_t>(width / side_) + 1;
  rows_ = static_cast<std::size_t>(height / side_) + 1;

  std::vector<Shadow> shadows;
  shadows.reserve(spheres.size());
  begin_.assign(columns_ * rows_ + 1, 0);
  std::size_t entries = 0;
  const auto cellOf = [this](double along, std::size_t cells) {
    return std::min(static_cast<std::size_t>(std::max(along, 0.0) / side_), cells - 1);
  };
  for (const Sphere& sphere : spheres) {
    const double reach = sphere.radius + margin + rounding;
    const double u = core::dot(sphere.centre, across_) - lowU_;
    const double v = core::dot(sphere.centre, up_) - lowV_;
    const Shadow shadow{cellOf(u - reach, columns_), cellOf(u + reach, columns_), cellOf(v - reach, rows_),
                        cellOf(v + reach, rows_)};
    entries += (shadow.right - shadow.left + 1) * (shadow.high - shadow.low + 1);
    if (entries > kMostEntriesOfSphere * spheres.size()) {
      return;
    }
    shadows.push_back(shadow);
  }
  const auto forCells = [&](const Shadow& shadow, const auto& take) {
    for (std::size_t row = shadow.low; row <= shadow.high; ++row) {
      for (std::size_t cell = row * columns_ + shadow.left; cell <= row * columns_ + shadow.right; ++cell) {
        take(cell);
      }
    }
  };
  for (const Shadow& shadow : shadows) {
    forCells(shadow, [this](std::size_t cell) { ++begin_[cell + 1]; });
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  entries_.resize(entries);
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::uint32_t index = 0; index < spheres.size(); ++index) {
    forCells(shadows[index], [&](std::size_t cell) { entries_[next[cell]++] = index; });
  }
  isMade_ = true;
}

}  // namespace espalier::environment
