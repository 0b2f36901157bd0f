#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/export/mesh.h"

namespace espalier::turtle {

/// The normal of a polygon that need not be plane nor convex, by the sum over its edges (Newell; Sutherland, Sproull &
/// Schumacker 1974): its length is twice the area of a plane polygon; zero when there is none.
[[nodiscard]] core::Vec3 newellNormal(std::span<const core::Vec3> vertices);

/// Triangles of a simple polygon as indices of its vertices, count - 2 of them, with the polygon's own sense: ears are
/// cut off in its projection along `normal`. A polygon that crosses itself gives count - 2 triangles that cover it in
/// some way. Repeated vertices are allowed. O(n²) at worst, O(n) for convex polygons.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> triangulate(std::span<const core::Vec3> vertices,
                                                                    const core::Vec3& normal);

/// A filled polygon with one normal; texture coordinates run over its bounding box in its plane, from 0 to 1.
void appendPolygon(Mesh& mesh, std::span<const core::Vec3> vertices);

}  // namespace espalier::turtle
