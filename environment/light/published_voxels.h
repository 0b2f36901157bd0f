#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "environment/geometry/sphere_tree.h"

namespace espalier::environment {

/// The voxel grid of the published programs chiba and takenaka over the box of all spheres, with their traversal, which
/// leaves the grid's corner out when it chooses the next voxel and so misses spheres where that corner is not the
/// origin. Only their compatible modes use it.
class PublishedVoxels {
 public:
  PublishedVoxels(std::span<const Sphere> spheres, const std::array<std::size_t, 3>& size);

  /// Calls `visit(index)` once for every sphere in the voxels that the traversal finds.
  template <typename Visit>
  void visitRay(const Ray& ray, const Visit& visit) {
    ++ray_;
    Walk walk = begin(ray);
    while (isInside(walk)) {
      for (const std::uint32_t sphere : members_[voxelOf(walk)]) {
        if (lastRay_[sphere] != ray_) {
          lastRay_[sphere] = ray_;
          visit(sphere);
        }
      }
      if (!advance(walk)) {
        return;
      }
    }
  }

 private:
  struct Walk {
    std::array<double, 3> origin{};
    std::array<double, 3> direction{};
    std::array<std::int64_t, 3> voxel{};
  };

  [[nodiscard]] Walk begin(const Ray& ray) const;
  [[nodiscard]] bool isInside(const Walk& walk) const;
  [[nodiscard]] std::size_t voxelOf(const Walk& walk) const;
  [[nodiscard]] bool advance(Walk& walk) const;
  [[nodiscard]] std::int64_t clampedVoxel(double coordinate, std::size_t axis) const;

  std::array<double, 3> low_{};
  std::array<double, 3> side_{};  // of a voxel
  std::array<std::int64_t, 3> size_{};
  std::vector<std::vector<std::uint32_t>> members_;  // spheres by voxel
  std::vector<std::uint64_t> lastRay_;               // the ray that met a sphere last
  std::uint64_t ray_ = 0;
};

}  // namespace espalier::environment
