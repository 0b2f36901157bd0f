#pragma once

#include "engine/core/frame.h"
#include "engine/core/vec3.h"

namespace espalier::turtle {

/// A plant's own coordinates: those in which an unplaced turtle starts at the origin with the initial frame. A model's
/// numbers (@M, @R, ?P, ?H, ...) are in them, so that a plant grows the same wherever it is placed; scene, records and
/// queries to the environment are in the world's.
class PlantCoordinates {
 public:
  PlantCoordinates() = default;
  PlantCoordinates(const core::Vec3& origin, const core::Frame& frame)
      : origin_(origin), x_(-frame.left), y_(frame.heading), z_(-frame.up), isTurned_(frame != core::Frame{}) {}

  [[nodiscard]] core::Vec3 toWorldDirection(const core::Vec3& d) const {
    return isTurned_ ? d.x * x_ + d.y * y_ + d.z * z_ : d;
  }
  [[nodiscard]] core::Vec3 toWorldPoint(const core::Vec3& p) const { return origin_ + toWorldDirection(p); }
  [[nodiscard]] core::Vec3 toPlantDirection(const core::Vec3& d) const {
    return isTurned_ ? core::Vec3{core::dot(d, x_), core::dot(d, y_), core::dot(d, z_)} : d;
  }
  [[nodiscard]] core::Vec3 toPlantPoint(const core::Vec3& p) const { return toPlantDirection(p - origin_); }

 private:
  core::Vec3 origin_;
  core::Vec3 x_{1.0, 0.0, 0.0};
  core::Vec3 y_{0.0, 1.0, 0.0};
  core::Vec3 z_{0.0, 0.0, 1.0};
  bool isTurned_ = false;
};

}  // namespace espalier::turtle
