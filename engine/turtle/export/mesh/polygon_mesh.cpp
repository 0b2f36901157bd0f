#include "engine/turtle/export/mesh/polygon_mesh.h"

#include <algorithm>
#include <array>

#include "engine/core/polygon.h"

namespace espalier::turtle {

using core::Vec3;

void appendPolygon(Mesh& mesh, std::span<const Vec3> vertices) {
  if (vertices.size() < 3) {
    return;
  }
  const Vec3 sum = core::newellNormal(vertices);
  const Vec3 normal = core::length(sum) > 0.0 ? core::normalised(sum) : Vec3{0.0, 1.0, 0.0};
  const std::vector<std::array<double, 2>> points = core::projectedCorners(vertices, normal);
  std::array<double, 2> low = points[0];
  std::array<double, 2> high = points[0];
  for (const std::array<double, 2>& p : points) {
    low = {std::min(low[0], p[0]), std::min(low[1], p[1])};
    high = {std::max(high[0], p[0]), std::max(high[1], p[1])};
  }
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto share = [&](const std::array<double, 2>& p, std::size_t k) {
    return high[k] > low[k] ? (p[k] - low[k]) / (high[k] - low[k]) : 0.0;
  };
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    mesh.positions.push_back(vertices[i]);
    mesh.normals.push_back(normal);
    mesh.coordinates.push_back({share(points[i], 0), share(points[i], 1)});
  }
  for (const auto& triangle : core::triangulate(vertices, normal)) {
    mesh.faces.push_back({first + triangle[0], first + triangle[1], first + triangle[2], Mesh::kNoVertex});
  }
}

}  // namespace espalier::turtle
