#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/picture/raster_camera.h"
#include "engine/turtle/export/picture/raster_shading.h"
#include "engine/turtle/export/picture/raster_target.h"

namespace espalier::turtle {

/// One end of a piece of a line.
struct LineEnd {
  core::Vec3 place;
  core::Vec3 tangent;   // unit; halves the angle to the neighbour where two pieces join
  core::Vec3 left;      // of the turtle: the plane of a strip
  double radius = 0.5;  // half the width: world units, or pixels when the line style is pixel
  enum class Shape : std::uint8_t { Joint, Round, Flat };
  Shape shape = Shape::Joint;
};

/// Draws shapes as triangles, only as fine as can be seen: what faces away from the viewer is left out where the front
/// hides it.
class RasterPen {
 public:
  /// All must outlive the object. `organ` numbers what is drawn.
  RasterPen(const RasterCamera& camera, const RasterShading& shading, const Look& look, std::uint32_t organ,
            std::vector<RasterTriangle>& triangles);

  /// A mesh with its normals, and the texture of its look. Lines, balls and text are plain.
  void mesh(const Mesh& mesh);
  /// A round line, shaded as a cylinder, of which the half toward the viewer is drawn.
  void roundLine(const LineEnd& a, const LineEnd& b);
  /// A flat strip in the plane of the turtle's H and L.
  void strip(const LineEnd& a, const LineEnd& b);
  /// A line of so many pixels, without shading.
  void pixelLine(const LineEnd& a, const LineEnd& b);
  /// The half of a ball that faces the viewer.
  void ball(const core::Vec3& centre, double radius);
  /// A disc that faces the viewer, as near as the front of a ball would be; its rim is darker, so that discs before one
  /// another can be told apart.
  void screenDisc(const core::Vec3& centre, double radius);
  /// A line of text that begins at a place, before everything else.
  void text(const core::Vec3& place, std::string_view text);

 private:
  [[nodiscard]] RasterVertex vertex(const core::Vec3& place, const core::Vec3& normal) const;
  [[nodiscard]] RasterVertex plainVertex(const core::Vec3& place) const;
  /// The vertex with the place of the texture that the look wears.
  [[nodiscard]] RasterVertex wornVertex(RasterVertex vertex, const core::Vec3& place,
                                        const std::array<double, 2>& uv) const;
  void triangle(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c);
  void quad(const RasterVertex& a, const RasterVertex& b, const RasterVertex& c, const RasterVertex& d);
  /// The end of a round line, where it faces the viewer.
  void flatEnd(const LineEnd& end, double radius, const core::Vec3& outward);
  /// A disc on the page; its rim has `rimShade` of the colour.
  void pageDisc(const RasterVertex& centre, double radius, float rimShade = 1.0F);
  void edge(const core::Vec3& a, const core::Vec3& b);
  [[nodiscard]] double leastRadius(const core::Vec3& place, double radius) const;

  const RasterCamera& camera_;
  const RasterShading& shading_;
  const Look& look_;
  std::uint32_t organ_;
  std::vector<RasterTriangle>& triangles_;
};

}  // namespace espalier::turtle
