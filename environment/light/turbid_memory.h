#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/grid_axes.h"
#include "environment/light/voxel_field.h"

namespace espalier::environment {

/// What places were told about the light in the step before. It is told again, the same numbers, as long as no voxel on
/// the way to the light has changed; so a step in which little changed costs little, and its answers are those of a
/// step that computes all of them, bit by bit.
class TurbidMemory {
 public:
  struct Answer {
    core::Vec3 place;
    std::size_t count = 0;           // of the values that are known
    std::array<double, 5> values{};  // light, its slopes along x, y and z, what a leaf absorbs
  };

  /// Forgets everything.
  void clear();

  /// Begins a step with the contents of `field`; answers kept since the last call are those of the step before.
  /// O(voxels + answers log answers).
  void begin(const VoxelField& field, const VoxelField::Shape& shape, const GridAxes& axes);

  /// What this place was told, if at least `count` values are known and the contents are the same everywhere within a
  /// voxel beside the lines along `directions`; null otherwise. O(directions · voxels on a line / 8).
  [[nodiscard]] const Answer* find(const core::Vec3& place, std::size_t count,
                                   std::span<const core::Vec3> directions) const;

  /// Keeps an answer of this step for the next.
  void keep(const Answer& answer);

 private:
  std::vector<Answer> known_;          // of the step before, sorted by place
  std::vector<Answer> next_;           // of this one
  std::vector<double> contents_;       // of the field in this step
  std::optional<VoxelField> touched_;  // blocks of voxels, 1: something within two voxels changed; none: nothing did
};

}  // namespace espalier::environment
