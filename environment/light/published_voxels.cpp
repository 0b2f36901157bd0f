#include "environment/light/published_voxels.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace espalier::environment {

namespace {

std::array<float, 3> coordinatesOf(const FloatVec& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

PublishedVoxels::PublishedVoxels(std::span<const FloatSphere> spheres, const std::array<std::size_t, 3>& cells,
                                 float beamRadius)
    : spheres_(spheres), lastEntry_(cells[0] * cells[1] * cells[2]), lastRay_(spheres.size(), 0) {
  float largest = 0.0F;
  std::array<float, 3> high{};
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const auto centre = coordinatesOf(spheres[i].centre);
    const float radius = spheres[i].radius;
    largest = std::max(largest, radius);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float low = centre[axis] - radius;
      low_[axis] = i == 0 ? low : std::min(low_[axis], low);
      high[axis] = i == 0 ? centre[axis] + radius : std::max(high[axis], centre[axis] + radius);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells_[axis] = static_cast<std::int64_t>(cells[axis]);
    side_[axis] = (high[axis] - low_[axis]) / static_cast<float>(cells[axis]);
  }
  const float halfDiagonal = 0.5F * length({side_[0], side_[1], side_[2]});
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    enter(i, spheres[i].radius + largest * beamRadius, halfDiagonal);
  }
}

std::optional<turtle::EnvironmentError> PublishedVoxels::tooManyEntries() const {
  if (entries_.size() <= kMostEntries) {
    return std::nullopt;
  }
  return turtle::EnvironmentError{"The spheres fill more than " + std::to_string(kMostEntries) +
                                      " voxels in all, and that is the limit. Give a 'grid size' with fewer voxels.",
                                  false};
}

void PublishedVoxels::enter(std::uint32_t sphere, float reach, float halfDiagonal) {
  const auto centre = coordinatesOf(spheres_[sphere].centre);
  Voxel first{};
  Voxel last{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // one voxel more than the box of the sphere
    first[axis] = std::max<std::int64_t>(clampedIndex(centre[axis] - reach, axis) - 1, 0);
    last[axis] = std::min(clampedIndex(centre[axis] + reach, axis) + 1, cells_[axis] - 1);
  }
  Voxel at{};
  for (at[0] = first[0]; at[0] <= last[0]; ++at[0]) {
    for (at[1] = first[1]; at[1] <= last[1]; ++at[1]) {
      for (at[2] = first[2]; at[2] <= last[2]; ++at[2]) {
        std::array<float, 3> middle{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          middle[axis] = low_[axis] + (static_cast<float>(at[axis]) + 0.5F) * side_[axis];
        }
        if (length(FloatVec{middle[0], middle[1], middle[2]} - spheres_[sphere].centre) <= reach + halfDiagonal) {
          if (entries_.size() > kMostEntries) {
            return;
          }
          std::uint32_t& lastEntry = lastEntry_[indexOf(at)];
          entries_.push_back({sphere, lastEntry});
          lastEntry = static_cast<std::uint32_t>(entries_.size() - 1);
        }
      }
    }
  }
}

std::int64_t PublishedVoxels::clampedIndex(float place, std::size_t axis) const {
  const float index = (place - low_[axis]) / side_[axis];
  const auto last = static_cast<float>(cells_[axis] - 1);
  return index > 0.0F ? static_cast<std::int64_t>(std::min(index, last)) : 0;  // 0 also for a box without extent
}

PublishedVoxels::Voxel PublishedVoxels::voxelOf(const FloatVec& point) const {
  return {clampedIndex(point.x, 0), clampedIndex(point.y, 1), clampedIndex(point.z, 2)};
}

std::size_t PublishedVoxels::indexOf(const Voxel& voxel) const {
  return static_cast<std::size_t>((voxel[0] * cells_[1] + voxel[1]) * cells_[2] + voxel[2]);
}

bool PublishedVoxels::advance(Voxel& voxel, const FloatVec& origin, const FloatVec& direction) const {
  const auto from = coordinatesOf(origin);
  const auto along = coordinatesOf(direction);
  std::size_t nearest = 3;
  float nearestWay = 0.0F;
  float nearestSpeed = 0.0F;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float speed = std::abs(along[axis]);
    if (!(speed > 0.0F)) {
      continue;
    }
    // the border ahead without the grid's corner, and the way to it without its sign
    const float middle = (static_cast<float>(voxel[axis]) + 0.5F) * side_[axis];
    const float half = 0.5F * side_[axis];
    const float way = std::abs((along[axis] < 0.0F ? middle - half : middle + half) - from[axis]);
    // ways divided by speeds, compared by products
    if (nearest == 3 || way * nearestSpeed < nearestWay * speed) {
      nearest = axis;
      nearestWay = way;
      nearestSpeed = speed;
    }
  }
  if (nearest == 3) {
    return false;
  }
  voxel[nearest] += along[nearest] < 0.0F ? -1 : 1;
  return voxel[nearest] >= 0 && voxel[nearest] < cells_[nearest];
}

}  // namespace espalier::environment
