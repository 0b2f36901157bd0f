#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/language/view_settings.h"
#include "engine/turtle/scene.h"

namespace espalier::turtle {

/// A small mesh of triangles and quads with a normal and texture coordinates for each vertex.
struct Mesh {
  static constexpr std::uint32_t kNoVertex = 0xFFFFFFFF;

  std::vector<core::Vec3> positions;
  std::vector<core::Vec3> normals;                  // (vertexCount), unit
  std::vector<std::array<double, 2>> coordinates;   // (vertexCount)
  std::vector<std::array<std::uint32_t, 4>> faces;  // a triangle's fourth is kNoVertex

  void clear();
};

/// The samples of a bicubic Bezier patch, rows along s.
void appendPatch(Mesh& mesh, const std::array<core::Vec3, 16>& points, int subdivisionS, int subdivisionT);

/// A surface `~c` where the turtle placed it (FILES §6.1).
void appendSurface(Mesh& mesh, const SurfaceInstance& instance, const language::ViewSettings& view);

/// A sphere of `rings` by `sides` quads.
void appendSphere(Mesh& mesh, const core::Vec3& centre, double diameter, int rings, int sides);

/// A disc in the plane of H and L.
void appendDisc(Mesh& mesh, const Ball& ball, int sides);

/// One ring of a tube: `sides + 1` vertices, the last at the place of the first (the seam of the texture).
struct TubeRing {
  core::Vec3 centre;
  core::Vec3 up;    // where the first vertex is
  core::Vec3 side;  // a quarter turn on
  double radius = 0.5;
  double along = 0.0;  // second texture coordinate
};

/// A tube through rings with shared vertices, closed at both ends.
void appendTube(Mesh& mesh, const std::vector<TubeRing>& rings, int sides);

/// A generalized cylinder: Hermite or B-spline through its points, circular or with the contours of the view file, with
/// the least twist unless the view file wants the turtle's.
void appendCylinder(Mesh& mesh, const GeneralizedCylinder& cylinder, const language::ViewSettings& view);

/// `sides + 1` points of a contour at equal distances along it (FILES §8); a circle when `id` is not in the view file.
[[nodiscard]] std::vector<core::Vec3> sampleContour(const language::ViewSettings& view, std::int32_t id, int sides);

}  // namespace espalier::turtle
