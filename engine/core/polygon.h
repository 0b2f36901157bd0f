#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::core {

/// The normal of a polygon, which need not be plane or convex, by the sum over its edges (Newell; Sutherland, Sproull &
/// Schumacker 1974). Its length is twice the area of a plane polygon; zero for a polygon without area.
[[nodiscard]] Vec3 newellNormal(std::span<const Vec3> vertices);

/// The vertexCount - 2 triangles of a simple polygon, as indices of its vertices, with the orientation of the polygon.
/// Cuts ears off the projection along `normal`. A polygon that crosses itself gives as many triangles, which cover it
/// somehow. Vertices may repeat. About O(n log n), also where the polygon crosses itself everywhere; O(n^1.5) with many
/// long spikes; O(n²) when most vertices lie in a few places. Throws WorkStopped.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> triangulate(std::span<const Vec3> vertices, const Vec3& normal);

/// The corners of a polygon in the plane of the unit vector `normal`, relative to the first corner. Counter-clockwise
/// in the plane is counter-clockwise for a viewer towards whom the normal points.
[[nodiscard]] std::vector<std::array<double, 2>> projectedCorners(std::span<const Vec3> vertices, const Vec3& normal);

}  // namespace espalier::core
