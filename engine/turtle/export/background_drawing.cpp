#include "engine/turtle/export/background_drawing.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace espalier::turtle {
namespace {

using core::Vec3;

constexpr double kCosineOfSmoothEdge = 0.766;  // 40 degrees
constexpr core::Frame kSceneFrame{.heading = {0.0, 1.0, 0.0}, .left = {1.0, 0.0, 0.0}, .up = {0.0, 0.0, 1.0}};

/// The triangles of a shape with the normals of their corners.
void appendTriangles(const files::BackgroundShape& shape, std::vector<files::SurfaceTriangle>& triangles) {
  // twice the area as a vector, for each triangle, and the triangles at each corner
  std::vector<Vec3> areas;
  std::vector<std::vector<std::uint32_t>> around(shape.vertices.size());
  for (const auto& corners : shape.triangles) {
    const Vec3& a = shape.vertices[corners[0]];
    const Vec3 area = core::cross(shape.vertices[corners[1]] - a, shape.vertices[corners[2]] - a);
    for (const std::uint32_t corner : corners) {
      around[corner].push_back(static_cast<std::uint32_t>(areas.size()));
    }
    areas.push_back(area);
  }
  for (std::size_t i = 0; i < shape.triangles.size(); ++i) {
    if (!(core::length(areas[i]) > 0.0)) {
      continue;  // the tip of a cone, or equal points
    }
    const Vec3 own = core::normalised(areas[i]);
    files::SurfaceTriangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t corner = shape.triangles[i][k];
      triangle.points[k] = shape.vertices[corner];
      // the normals of neighbours across a smooth edge count by their area
      Vec3 sum;
      for (const std::uint32_t other : around[corner]) {
        const double length = core::length(areas[other]);
        if (length > 0.0 && core::dot(areas[other], own) > kCosineOfSmoothEdge * length) {
          sum = sum + areas[other];
        }
      }
      triangle.normals[k] = core::normalised(sum);
    }
    triangles.push_back(triangle);
  }
}

}  // namespace

BackgroundDrawing::BackgroundDrawing(const files::BackgroundScene& background) {
  std::vector<std::vector<files::SurfaceTriangle>> triangles(background.materials.size());
  for (const files::BackgroundShape& shape : background.shapes) {
    if (shape.isSphere) {
      scene_.balls.push_back({.centre = shape.centre,
                              .frame = kSceneFrame,
                              .diameter = 2.0 * shape.radius,
                              .colour = static_cast<std::int32_t>(shape.material)});
    } else {
      appendTriangles(shape, triangles[shape.material]);
    }
  }
  palette_.usesMaterials = true;
  auto& materials = palette_.materials[palette_.base];
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    materials[i] = background.materials[i];
    if (!triangles[i].empty()) {
      scene_.surfaces.push_back({.surface = static_cast<std::uint32_t>(view_.triangleSurfaces.size()),
                                 .isTriangleSurface = true,
                                 .position = {},
                                 .frame = kSceneFrame,
                                 .colour = static_cast<std::int32_t>(i)});
      view_.triangleSurfaces.push_back({'b', {}, std::move(triangles[i]), 0});
    }
  }
}

ExportInput BackgroundDrawing::input(const ExportInput& model) const {
  return {.scene = scene_,
          .view = view_,
          .palette = &palette_,
          .detail = model.detail,
          .threads = model.threads,
          .isBackground = true,
          .picture = model.picture};
}

}  // namespace espalier::turtle
