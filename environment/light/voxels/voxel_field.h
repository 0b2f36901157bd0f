#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/geometry/box_tree.h"
#include "environment/geometry/grid_axes.h"

namespace espalier::environment {

/// A box of cubic voxels with a number each, layer by layer along the world's up, which is an axis of the world. With
/// `isPeriodic` the box repeats without end in the two horizontal directions.
class VoxelField {
 public:
  struct Shape {
    core::Vec3 position;                         // corner with the smallest coordinates
    std::array<std::int64_t, 3> cells{1, 1, 1};  // along the world's x, y, z
    double voxelSize = 1.0;
    bool isPeriodic = false;
  };
  /// A voxel by its places along the two horizontal axes of the world (in the order x, y, z) and along up, from below.
  struct Voxel {
    std::int64_t a = 0;
    std::int64_t b = 0;
    std::int64_t layer = 0;
  };

  VoxelField() = default;
  VoxelField(const Shape& shape, const GridAxes& axes);

  [[nodiscard]] const std::vector<double>& values() const { return values_; }
  [[nodiscard]] std::vector<double>& values() { return values_; }
  [[nodiscard]] std::int64_t layerCount() const { return layers_; }
  [[nodiscard]] const Shape& shape() const { return shape_; }
  /// Voxels along the two horizontal axes, and layers.
  [[nodiscard]] std::array<std::int64_t, 3> counts() const { return {countA_, countB_, layers_}; }
  /// A direction of the world along the two horizontal axes and up.
  [[nodiscard]] std::array<double, 3> toOwn(const core::Vec3& direction) const;

  /// The box; a periodic one is infinite horizontally.
  [[nodiscard]] Bounds box() const;
  /// The voxel that a point is in; far outside, one outside (periodic: horizontally always inside).
  [[nodiscard]] Voxel voxelOf(const core::Vec3& point) const;
  /// Index into values(); nothing outside the box.
  [[nodiscard]] std::optional<std::size_t> indexOf(const Voxel& voxel) const;

  /// The index of the voxel that lies so many voxels beside and above this one. A periodic box goes on at its border.
  [[nodiscard]] std::optional<std::size_t> indexBeside(const Voxel& voxel, std::int64_t a, std::int64_t b,
                                                       std::int64_t layers) const;

  /// Whether a voxel is so far outside that none within `reach` of it, or below it, is in the box.
  [[nodiscard]] bool isBeyond(const Voxel& voxel, std::int64_t reach) const;

  /// The middle of the voxel with this index. O(1).
  [[nodiscard]] core::Vec3 middleOf(std::size_t index) const;

  /// Integral of the values along the ray from a point in the direction of a unit vector until it leaves the box.
  /// Periodic: after 100,000 voxel sides the rest of a way counts as the first part. O(voxels on the way).
  [[nodiscard]] double integralAlong(const core::Vec3& from, const core::Vec3& direction) const;

  /// Prepares boxSum() for the present values: sums over rectangles of every layer. One pass that reads and writes one
  /// number a voxel.
  void sumLayers();
  /// Sum of the values in the layer of a voxel over all voxels at most `reach` away along both horizontal axes. 0 in
  /// layers outside the box; periodic: with all repetitions. O(1).
  [[nodiscard]] double boxSum(const Voxel& voxel, std::int64_t reach) const;

 private:
  /// The part of a ray in the box, or between its planes when it repeats itself. Lengths in sides of voxels, axes in
  /// the order a, b, layer; layers count upwards.
  struct Way {
    std::array<double, 3> start{};
    std::array<double, 3> step{};
    double begin = 0.0;  // along the ray
    double end = 0.0;
    double share = 1.0;  // whole length / length from begin to end
  };

  [[nodiscard]] Way wayOf(const core::Vec3& from, const core::Vec3& direction) const;
  /// Moves a far origin near, and cuts a way that is too long.
  void shorten(Way& way) const;

  [[nodiscard]] double sumBelow(std::int64_t layer, std::int64_t a, std::int64_t b) const {
    return sums_[static_cast<std::size_t>((layer * (countA_ + 1) + a) * (countB_ + 1) + b)];
  }

  Shape shape_;
  std::array<int, 3> axis_{0, 2, 1};  // world axes of a, b and up
  double sign_ = 1.0;                 // -1: layers count downwards along the axis
  std::int64_t countA_ = 0;
  std::int64_t countB_ = 0;
  std::int64_t layers_ = 0;
  std::vector<double> values_;  // (layer, a, b)
  std::vector<double> sums_;    // over all smaller a and b (layer, a + 1, b + 1)
};

}  // namespace espalier::environment
