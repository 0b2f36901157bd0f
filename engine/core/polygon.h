#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::core {

/// The normal of a polygon that need not be plane nor convex, by the sum over its edges (Newell; Sutherland, Sproull &
/// Schumacker 1974): its length is twice the area of a plane polygon; zero when there is none.
[[nodiscard]] Vec3 newellNormal(std::span<const Vec3> vertices);

/// Triangles of a simple polygon as indices of its vertices, count - 2 of them, with the polygon's own sense: ears are
/// cut off in its projection along `normal`. A polygon that crosses itself gives count - 2 triangles that cover it in
/// some way. Repeated vertices are allowed. O(n²) at worst, O(n) for convex polygons.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> triangulate(std::span<const Vec3> vertices, const Vec3& normal);

/// The corners of a polygon in the plane of the unit vector `normal`, relative to the first one; counter-clockwise
/// there is counter-clockwise seen from where the normal points.
[[nodiscard]] std::vector<std::array<double, 2>> projectedCorners(std::span<const Vec3> vertices, const Vec3& normal);

}  // namespace espalier::core
