#include "environment/light/published_voxels.h"

#include <algorithm>
#include <limits>

namespace espalier::environment {

namespace {}  // namespace

PublishedVoxels::PublishedVoxels(std::span<const Sphere> spheres, const std::array<std::size_t, 3>& size)
    : members_(size[0] * size[1] * size[2]), lastRay_(spheres.size(), 0) {
  std::array<double, 3> high{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size_[axis] = static_cast<std::int64_t>(size[axis]);
    low_[axis] = std::numeric_limits<double>::infinity();
    high[axis] = -low_[axis];
    for (const Sphere& sphere : spheres) {
      low_[axis] = std::min(low_[axis], componentsOf(sphere.centre)[axis] - sphere.radius);
      high[axis] = std::max(high[axis], componentsOf(sphere.centre)[axis] + sphere.radius);
    }
    side_[axis] =
        std::max(high[axis] - low_[axis], std::numeric_limits<double>::min()) / static_cast<double>(size[axis]);
  }
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    std::array<std::int64_t, 3> first{};
    std::array<std::int64_t, 3> last{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] = clampedVoxel(componentsOf(spheres[i].centre)[axis] - spheres[i].radius, axis);
      last[axis] = clampedVoxel(componentsOf(spheres[i].centre)[axis] + spheres[i].radius, axis);
    }
    Walk at;
    for (at.voxel[0] = first[0]; at.voxel[0] <= last[0]; ++at.voxel[0]) {
      for (at.voxel[1] = first[1]; at.voxel[1] <= last[1]; ++at.voxel[1]) {
        for (at.voxel[2] = first[2]; at.voxel[2] <= last[2]; ++at.voxel[2]) {
          members_[voxelOf(at)].push_back(i);
        }
      }
    }
  }
}

std::int64_t PublishedVoxels::clampedVoxel(double coordinate, std::size_t axis) const {
  const double voxel = std::floor((coordinate - low_[axis]) / side_[axis]);
  return static_cast<std::int64_t>(std::clamp(voxel, 0.0, static_cast<double>(size_[axis] - 1)));
}

PublishedVoxels::Walk PublishedVoxels::begin(const Ray& ray) const {
  Walk walk{componentsOf(ray.origin), componentsOf(ray.direction), {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    walk.voxel[axis] = clampedVoxel(walk.origin[axis], axis);
  }
  return walk;
}

bool PublishedVoxels::isInside(const Walk& walk) const {
  bool isInside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    isInside = isInside && walk.voxel[axis] >= 0 && walk.voxel[axis] < size_[axis];
  }
  return isInside;
}

std::size_t PublishedVoxels::voxelOf(const Walk& walk) const {
  return static_cast<std::size_t>((walk.voxel[0] * size_[1] + walk.voxel[1]) * size_[2] + walk.voxel[2]);
}

bool PublishedVoxels::advance(Walk& walk) const {
  std::size_t nearest = 3;
  double nearestWay = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (walk.direction[axis] == 0.0) {
      continue;
    }
    // the voxel's far border as the published programs compute it, without low_[axis]
    const double border = static_cast<double>(walk.voxel[axis] + (walk.direction[axis] > 0.0 ? 1 : 0)) * side_[axis];
    const double way = (border - walk.origin[axis]) / walk.direction[axis];
    if (way < nearestWay) {
      nearestWay = way;
      nearest = axis;
    }
  }
  if (nearest == 3) {
    return false;
  }
  walk.voxel[nearest] += walk.direction[nearest] > 0.0 ? 1 : -1;
  return true;
}

}  // namespace espalier::environment
