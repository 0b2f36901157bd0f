#pragma once

#include <array>
#include <optional>
#include <span>

#include "engine/core/vec3.h"
#include "environment/geometry/box_tree.h"
#include "environment/geometry/sphere_tree.h"

namespace espalier::environment {

/// A straight line with round ends.
struct Capsule {
  core::Vec3 a, b;
  double radius = 0.0;
};

struct Triangle {
  std::array<core::Vec3, 3> corners;
};

/// A half-space: solid behind the plane through `point` with the unit vector `normal`.
struct HalfSpace {
  core::Vec3 point;
  core::Vec3 normal;
};

/// The nearest point of a surface. `distance` is negative inside a solid; `normal` points out of it.
struct SurfacePoint {
  double distance = 0.0;
  core::Vec3 point;
  core::Vec3 normal;
};

[[nodiscard]] Bounds boundsOf(const Sphere& sphere);
[[nodiscard]] Bounds boundsOf(const Capsule& capsule);
[[nodiscard]] Bounds boundsOf(const Triangle& triangle);

[[nodiscard]] core::Vec3 nearestOnSegment(const core::Vec3& a, const core::Vec3& b, const core::Vec3& p);

/// The nearest point of a triangle and the part of it that it lies on: 0 inside, 1–3 the side from that corner
/// (counted from 1), 4–6 the corner (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
struct TrianglePoint {
  core::Vec3 point;
  int feature = 0;
};
[[nodiscard]] TrianglePoint nearestOnTriangle(const Triangle& triangle, const core::Vec3& p);

[[nodiscard]] SurfacePoint nearestOn(const Sphere& sphere, const core::Vec3& p);
[[nodiscard]] SurfacePoint nearestOn(const Capsule& capsule, const core::Vec3& p);
[[nodiscard]] SurfacePoint nearestOn(const Bounds& box, const core::Vec3& p);
[[nodiscard]] SurfacePoint nearestOn(const HalfSpace& space, const core::Vec3& p);

/// Distance between a segment and a shape; 0 or less when they touch or one is inside the other.
[[nodiscard]] double segmentDistance(const core::Vec3& a, const core::Vec3& b, const core::Vec3& c,
                                     const core::Vec3& d);
[[nodiscard]] double distanceTo(const Sphere& sphere, const core::Vec3& a, const core::Vec3& b);
[[nodiscard]] double distanceTo(const Capsule& capsule, const core::Vec3& a, const core::Vec3& b);
[[nodiscard]] double distanceTo(const Bounds& box, const core::Vec3& a, const core::Vec3& b);
[[nodiscard]] double distanceTo(const HalfSpace& space, const core::Vec3& a, const core::Vec3& b);
[[nodiscard]] double distanceTo(const Triangle& triangle, const core::Vec3& a, const core::Vec3& b);

/// Length of a ray (unit direction) up to the shape; 0 inside a solid; nothing when the ray misses the shape.
[[nodiscard]] std::optional<double> rayTo(const Sphere& sphere, const core::Vec3& origin, const core::Vec3& direction);
[[nodiscard]] std::optional<double> rayTo(const Capsule& capsule, const core::Vec3& origin,
                                          const core::Vec3& direction);
[[nodiscard]] std::optional<double> rayTo(const Bounds& box, const core::Vec3& origin, const core::Vec3& direction);
[[nodiscard]] std::optional<double> rayTo(const HalfSpace& space, const core::Vec3& origin,
                                          const core::Vec3& direction);
[[nodiscard]] std::optional<double> rayTo(const Triangle& triangle, const core::Vec3& origin,
                                          const core::Vec3& direction);

}  // namespace espalier::environment
