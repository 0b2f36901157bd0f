#include "environment/output/point_voxels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

using Numbers = std::array<double, 3>;

Numbers numbersOf(const core::Vec3& v) {
  return {v.x, v.y, v.z};
}

turtle::Field emptyField(const VoxelBox& box, const char* name, const char* unit) {
  turtle::Field field;
  field.name = name;
  field.unit = unit;
  field.cells = box.cells;
  field.position = box.position;
  field.cellSize = box.cellSize;
  field.values.assign(box.cells[0] * box.cells[1] * box.cells[2], 0.0);
  return field;
}

/// The cells that a ray from `origin` to `end` meets, in order: `visit(cell, free path through it, whether it ends
/// there)`.
template <typename Visit>
void walk(const VoxelBox& box, const core::Vec3& origin, const core::Vec3& end, const Visit& visit) {
  const Numbers from = numbersOf(origin);
  const Numbers way = numbersOf(end - origin);
  const Numbers corner = numbersOf(box.position);
  const Numbers size = numbersOf(box.cellSize);
  const double length = core::length(end - origin);
  if (!(length > 0.0)) {
    return;
  }
  // the part of the ray in the box, in parts of the way to the end
  double enter = 0.0;
  double leave = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double low = corner[axis];
    const double high = corner[axis] + size[axis] * static_cast<double>(box.cells[axis]);
    if (way[axis] == 0.0) {
      if (from[axis] < low || from[axis] >= high) {
        return;
      }
      continue;
    }
    const double first = (low - from[axis]) / way[axis];
    const double second = (high - from[axis]) / way[axis];
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  if (!(enter < leave) || enter > 1.0) {
    return;
  }
  std::array<std::size_t, 3> cell{};
  Numbers next{};  // where the ray meets the next face across each axis
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double place = std::floor((from[axis] + way[axis] * enter - corner[axis]) / size[axis]);
    cell[axis] = static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(box.cells[axis] - 1)));
    const double face = corner[axis] + size[axis] * static_cast<double>(cell[axis] + (way[axis] > 0.0 ? 1 : 0));
    next[axis] = way[axis] == 0.0 ? std::numeric_limits<double>::infinity() : (face - from[axis]) / way[axis];
  }
  for (double at = enter;;) {
    const auto axis = static_cast<std::size_t>(std::min_element(next.begin(), next.end()) - next.begin());
    const double until = std::max(next[axis], at);
    const bool isEnd = until > 1.0;
    visit(cell[0] + box.cells[0] * (cell[1] + box.cells[1] * cell[2]), (until - at) * length, isEnd);
    const bool isLast = way[axis] > 0.0 ? cell[axis] + 1 == box.cells[axis] : cell[axis] == 0;
    if (isEnd || isLast) {
      return;
    }
    cell[axis] += way[axis] > 0.0 ? 1 : static_cast<std::size_t>(-1);
    at = until;
    next[axis] += size[axis] / std::abs(way[axis]);
  }
}

}  // namespace

turtle::Field countPoints(const ScannedPoints& points, const VoxelBox& box) {
  turtle::Field counts = emptyField(box, "pointCount", "1");
  const Numbers corner = numbersOf(box.position);
  const Numbers size = numbersOf(box.cellSize);
  for (std::size_t i = 0; i < points.places.size(); ++i) {
    if (!points.isPlant.empty() && points.isPlant[i] == 0) {
      continue;
    }
    const Numbers place = numbersOf(points.places[i]);
    std::array<double, 3> cell{};
    bool isInside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = std::floor((place[axis] - corner[axis]) / size[axis]);
      isInside = isInside && cell[axis] >= 0.0 && cell[axis] < static_cast<double>(box.cells[axis]);
    }
    if (isInside) {
      counts.values[static_cast<std::size_t>(cell[0]) +
                    box.cells[0] *
                        (static_cast<std::size_t>(cell[1]) + box.cells[1] * static_cast<std::size_t>(cell[2]))] += 1.0;
    }
  }
  return counts;
}

std::vector<turtle::Field> tracePulses(const ScannedPoints& points, const VoxelBox& box, const core::Vec3& scanner,
                                       double projection) {
  turtle::Field pulses = emptyField(box, "pulses", "1");
  turtle::Field gap = emptyField(box, "gapFraction", "1");
  turtle::Field density = emptyField(box, "leafAreaDensity", "1/length");
  std::vector<double> stopped(pulses.values.size(), 0.0);
  std::vector<double> paths(pulses.values.size(), 0.0);
  for (std::size_t i = 0; i < points.places.size(); ++i) {
    const double weight = points.returns.empty() ? 1.0 : 1.0 / static_cast<double>(points.returns[i]);
    const bool isPlant = points.isPlant.empty() || points.isPlant[i] != 0;
    walk(box, scanner, points.places[i], [&](std::size_t cell, double path, bool isEnd) {
      pulses.values[cell] += weight;
      paths[cell] += weight * path;
      stopped[cell] += isEnd && isPlant ? weight : 0.0;
    });
  }
  for (std::size_t cell = 0; cell < stopped.size(); ++cell) {
    const double reached = pulses.values[cell];
    const double part = reached > 0.0 ? 1.0 - stopped[cell] / reached : std::numeric_limits<double>::quiet_NaN();
    gap.values[cell] = part;
    density.values[cell] =
        part > 0.0 ? -core::log(part) / (projection * paths[cell] / reached) : std::numeric_limits<double>::quiet_NaN();
    density.values[cell] += 0.0;  // no -0
  }
  return {std::move(pulses), std::move(gap), std::move(density)};
}

}  // namespace espalier::environment
