#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/light/voxels/voxel_field.h"

namespace espalier::environment {

/// The part of the light that came to places from each direction in the step before. A direction from which no ray can
/// meet a changed voxel is not traced again. So a step with few changes costs little, and its answers are bitwise those
/// of a step that traces all directions.
///
/// A place has up to 7 rays from each direction: its own and those of its neighbours one voxel aside, for the gradient.
class TurbidMemory {
 public:
  static constexpr std::size_t kMostRays = 7;

  /// A place in this step.
  struct Place {
    std::span<const double> before;  // of the step before: parts of the light (rays, directions); empty: not known
    std::span<double> parts;         // to be filled, the same of this step; valid until the next call
    std::uint64_t touched = 0;       // bit d % 64: of the direction d something before the place may have changed
  };

  /// Forgets all places.
  void clear();

  /// Begins a step with the contents of `field`; places looked at since the last call are those of the step before.
  /// O(voxels + places log places + changed voxels · directions · voxels on a line).
  void begin(const VoxelField& field, const VoxelField::Shape& shape, std::span<const core::Vec3> directions);

  /// Enters a place with so many rays from each direction. O(log places). Keeps 8 bytes for each, up to 256 MB.
  [[nodiscard]] Place lookAt(const core::Vec3& place, std::size_t rayCount);

  /// Whether the direction `d` of a place has to be traced.
  [[nodiscard]] static bool isTouched(const Place& place, std::size_t d) {
    return place.before.empty() || (place.touched >> d % 64 & 1U) != 0;
  }

 private:
  struct Entry {
    core::Vec3 place;
    std::size_t rayCount = 0;
    std::size_t first = 0;  // in the parts
  };
  struct Step {
    std::vector<Entry> entries;
    std::vector<double> parts;  // of all entries, concatenated (rays, directions each)
  };

  [[nodiscard]] static bool isBefore(const Entry& a, const Entry& b);
  void touch(std::size_t voxel, std::size_t direction, const core::Vec3& towards);

  VoxelField field_;  // contents of this step
  VoxelField::Shape shape_;
  std::size_t directionCount_ = 0;
  Step before_;                         // sorted by place
  Step now_;                            // in the order in which places came
  std::vector<std::uint64_t> touched_;  // of every voxel, see Place; empty: nothing changed
  std::vector<double> unkept_;          // parts of a place that is not kept
};

}  // namespace espalier::environment
