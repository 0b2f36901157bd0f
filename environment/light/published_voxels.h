#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/turtle/environment_process.h"
#include "environment/geometry/float_vec.h"

namespace espalier::environment {

/// A sphere of the published programs.
struct FloatSphere {
  FloatVec centre;
  float radius = 0.0F;
};

/// The voxel grid of the published programs chiba and takenaka over the box of all spheres, with their traversal. It
/// leaves the grid's corner out when it computes the way to the next voxel, and takes that way without its sign. So it
/// misses spheres where that corner is not the origin. Only their compatible variants use it. All of it is in 32-bit
/// floats, operation by operation.
class PublishedVoxels {
 public:
  static constexpr std::size_t kMostVoxels = 100'000'000;
  static constexpr std::size_t kMostEntries = 200'000'000;  // spheres in voxels, 8 bytes each

  /// `spheres` must outlive the object. A sphere is entered in the voxels whose middle is at most half a voxel's
  /// diagonal outside it, when it is widened by `beamRadius` times the largest radius.
  PublishedVoxels(std::span<const FloatSphere> spheres, const std::array<std::size_t, 3>& cells, float beamRadius);

  /// The error of spheres that fill more voxels than memory may hold. Then no ray may be followed.
  [[nodiscard]] std::optional<turtle::EnvironmentError> tooManyEntries() const;

  /// Calls `visit(index)` once for every other sphere in the voxels that a ray from the middle of sphere `own` finds:
  /// voxel by voxel, in each the sphere that was entered last first.
  template <typename Visit>
  void visitRay(std::size_t own, const FloatVec& direction, const Visit& visit) {
    ++ray_;
    lastRay_[own] = ray_;
    const FloatVec& origin = spheres_[own].centre;
    Voxel voxel = voxelOf(origin);
    do {
      for (std::uint32_t at = lastEntry_[indexOf(voxel)]; at != 0; at = entries_[at].previous) {
        const std::uint32_t sphere = entries_[at].sphere;
        if (lastRay_[sphere] != ray_) {
          lastRay_[sphere] = ray_;
          visit(sphere);
        }
      }
    } while (advance(voxel, origin, direction));
  }

 private:
  using Voxel = std::array<std::int64_t, 3>;

  /// A sphere in a voxel, and the entry of that voxel before it. Entry 0 means none.
  struct Entry {
    std::uint32_t sphere = 0;
    std::uint32_t previous = 0;
  };

  [[nodiscard]] Voxel voxelOf(const FloatVec& point) const;
  [[nodiscard]] std::int64_t clampedIndex(float place, std::size_t axis) const;
  [[nodiscard]] std::size_t indexOf(const Voxel& voxel) const;
  /// Nothing is entered any more once there are too many entries.
  void enter(std::uint32_t sphere, float reach, float halfDiagonal);
  /// Goes to the next voxel of a ray. False: the ray leaves the grid, or the direction has no length.
  [[nodiscard]] bool advance(Voxel& voxel, const FloatVec& origin, const FloatVec& direction) const;

  std::span<const FloatSphere> spheres_;
  std::array<float, 3> low_{};
  std::array<float, 3> side_{};  // of a voxel
  std::array<std::int64_t, 3> cells_{};
  std::vector<Entry> entries_{1};
  std::vector<std::uint32_t> lastEntry_;  // by voxel
  std::vector<std::uint64_t> lastRay_;    // the ray that met a sphere last
  std::uint64_t ray_ = 0;
};

}  // namespace espalier::environment
