#include "environment/competition/marker_grid.h"

#include <algorithm>
#include <cmath>

namespace espalier::environment {
namespace {

constexpr double kCellsPerReach = 4.0;

std::size_t clamped(double cell, std::size_t count) {
  // a comparison with NaN is false: an infinite extent has one cell
  if (!(cell > 0.0)) {
    return 0;
  }
  return cell < static_cast<double>(count) ? static_cast<std::size_t>(cell) : count - 1;
}

}  // namespace

MarkerGrid::MarkerGrid(std::span<const Marker> markers, double reach) : size_(reach / kCellsPerReach) {
  if (markers.empty()) {
    return;
  }
  Bounds bounds{markers[0].place, markers[0].place};
  for (const Marker& marker : markers) {
    const core::Vec3& p = marker.place;
    bounds.low = {std::min(bounds.low.x, p.x), std::min(bounds.low.y, p.y), std::min(bounds.low.z, p.z)};
    bounds.high = {std::max(bounds.high.x, p.x), std::max(bounds.high.y, p.y), std::max(bounds.high.z, p.z)};
  }
  low_ = bounds.low;
  const core::Vec3 extent = bounds.high - bounds.low;
  if (std::isfinite(extent.x) && std::isfinite(extent.y) && std::isfinite(extent.z)) {
    // not many more cells than markers: markers far apart have larger cells
    const double mostCells = 2.0 * static_cast<double>(markers.size()) + 64.0;
    const auto along = [this](double length) { return std::floor(length / size_) + 1.0; };
    while (along(extent.x) * along(extent.y) * along(extent.z) > mostCells) {
      size_ *= 1.25;
    }
    counts_ = {static_cast<std::size_t>(along(extent.x)), static_cast<std::size_t>(along(extent.y)),
               static_cast<std::size_t>(along(extent.z))};
  }
  // count, then place: the order of the markers within a cell stays
  std::vector<std::size_t> cells;
  cells.reserve(markers.size());
  begins_.assign(counts_[0] * counts_[1] * counts_[2] + 1, 0);
  for (const Marker& marker : markers) {
    const Cell cell = cellOf(marker.place);
    cells.push_back((cell[0] * counts_[1] + cell[1]) * counts_[2] + cell[2]);
    ++begins_[cells.back() + 1];
  }
  for (std::size_t cell = 1; cell < begins_.size(); ++cell) {
    begins_[cell] += begins_[cell - 1];
  }
  std::vector<std::size_t> next = begins_;
  markers_.resize(markers.size());
  for (std::size_t i = 0; i < markers.size(); ++i) {
    markers_[next[cells[i]]++] = markers[i];
  }
}

MarkerGrid::Cell MarkerGrid::cellOf(const core::Vec3& place) const {
  return {clamped((place.x - low_.x) / size_, counts_[0]), clamped((place.y - low_.y) / size_, counts_[1]),
          clamped((place.z - low_.z) / size_, counts_[2])};
}

Bounds boxOfCone(const core::Vec3& apex, const core::Vec3& direction, double radius, double cosine) {
  // rounding, and a direction that is not quite of length 1
  constexpr double kMargin = 1e-6;
  const double reach = radius * (1.0 + kMargin);
  const bool isUnit = std::abs(core::dot(direction, direction) - 1.0) < kMargin;
  const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  // the farthest that the cone reaches along an axis: its apex, its rim or the ball itself
  const auto along = [&](double component) {
    if (!isUnit || cosine < -1.0 || component >= cosine - 2.0 * kMargin) {
      return reach;
    }
    const double rim = component * cosine + std::sqrt(std::max(0.0, 1.0 - component * component)) * sine;
    return std::clamp(rim + 4.0 * kMargin, 0.0, 1.0) * reach;
  };
  const core::Vec3& d = direction;
  // the corner keeps a margin for the rounding of large coordinates
  const auto low = [&](double from, double component) { return from - along(-component) - kMargin * radius; };
  const auto high = [&](double from, double component) { return from + along(component) + kMargin * radius; };
  return {{low(apex.x, d.x), low(apex.y, d.y), low(apex.z, d.z)},
          {high(apex.x, d.x), high(apex.y, d.y), high(apex.z, d.z)}};
}

}  // namespace espalier::environment
