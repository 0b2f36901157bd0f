#include "engine/turtle/export/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace espalier::turtle {

using core::Vec3;

namespace {

std::array<double, 4> bernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}

std::array<double, 4> bernsteinSlope(double t) {
  const double s = 1.0 - t;
  return {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t};
}

Vec3 tensor(const std::array<Vec3, 16>& points, const std::array<double, 4>& s, const std::array<double, 4>& t) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      sum = sum + (s[i] * t[j]) * points[i * 4 + j];
    }
  }
  return sum;
}

// the quads of a grid of (rows + 1) by (columns + 1) vertices that begins at `first`
void appendGridFaces(Mesh& mesh, std::uint32_t first, std::uint32_t rows, std::uint32_t columns) {
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column;
      const std::uint32_t b = a + columns + 1;
      mesh.faces.push_back({a, a + 1, b + 1, b});
    }
  }
}

void appendVertex(Mesh& mesh, const Vec3& position, const Vec3& normal, double u, double v) {
  mesh.positions.push_back(position);
  mesh.normals.push_back(core::length(normal) > 0.0 ? core::normalised(normal) : Vec3{0.0, 1.0, 0.0});
  mesh.coordinates.push_back({u, v});
}

}  // namespace

void Mesh::clear() {
  positions.clear();
  normals.clear();
  coordinates.clear();
  faces.clear();
}

void appendPatch(Mesh& mesh, const std::array<Vec3, 16>& points, int subdivisionS, int subdivisionT) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i <= subdivisionS; ++i) {
    for (int j = 0; j <= subdivisionT; ++j) {
      const double s = static_cast<double>(i) / subdivisionS;
      const double t = static_cast<double>(j) / subdivisionT;
      const Vec3 alongS = tensor(points, bernsteinSlope(s), bernstein(t));
      const Vec3 alongT = tensor(points, bernstein(s), bernsteinSlope(t));
      appendVertex(mesh, tensor(points, bernstein(s), bernstein(t)), core::cross(alongT, alongS), s, t);
    }
  }
  appendGridFaces(mesh, first, static_cast<std::uint32_t>(subdivisionS), static_cast<std::uint32_t>(subdivisionT));
}

void appendSurface(Mesh& mesh, const SurfaceInstance& instance, const language::ViewSettings& view) {
  const core::Frame& frame = instance.frame;
  const auto toWorld = [&](const Vec3& d) { return d.x * frame.left + d.y * frame.heading + d.z * frame.up; };
  const auto place = [&](const Vec3& p) {
    return instance.position + toWorld({p.x * instance.scale.x, p.y * instance.scale.y, p.z * instance.scale.z});
  };
  if (instance.isTriangleSurface) {
    if (instance.surface >= view.triangleSurfaces.size()) {
      return;
    }
    for (const language::SurfaceTriangle& triangle : view.triangleSurfaces[instance.surface].triangles) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (std::size_t k = 0; k < 3; ++k) {
        appendVertex(mesh, place(triangle.points[k]), toWorld(triangle.normals[k]), k == 1 ? 1.0 : 0.0,
                     k == 2 ? 1.0 : 0.0);
      }
      mesh.faces.push_back({first, first + 1, first + 2, Mesh::kNoVertex});
    }
    return;
  }
  if (instance.surface >= view.surfaces.size()) {
    return;
  }
  const language::Surface& surface = view.surfaces[instance.surface];
  for (const language::SurfacePatch& patch : surface.patches) {
    std::array<Vec3, 16> points;
    std::transform(patch.points.begin(), patch.points.end(), points.begin(), place);
    appendPatch(mesh, points, std::clamp(surface.subdivisionS, 1, 100), std::clamp(surface.subdivisionT, 1, 100));
  }
}

void appendSphere(Mesh& mesh, const Vec3& centre, double diameter, int rings, int sides) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i <= rings; ++i) {
    const double latitude = std::numbers::pi * i / rings;
    for (int j = 0; j <= sides; ++j) {
      const double longitude = 2.0 * std::numbers::pi * j / sides;
      const Vec3 normal{std::sin(latitude) * std::cos(longitude), -std::cos(latitude),
                        -std::sin(latitude) * std::sin(longitude)};
      appendVertex(mesh, centre + (diameter / 2.0) * normal, normal, static_cast<double>(j) / sides,
                   static_cast<double>(i) / rings);
    }
  }
  appendGridFaces(mesh, first, static_cast<std::uint32_t>(rings), static_cast<std::uint32_t>(sides));
}

void appendDisc(Mesh& mesh, const Ball& ball, int sides) {
  const auto centre = static_cast<std::uint32_t>(mesh.positions.size());
  appendVertex(mesh, ball.centre, ball.frame.up, 0.5, 0.5);
  for (int k = 0; k <= sides; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    const Vec3 direction = std::cos(angle) * ball.frame.heading + std::sin(angle) * ball.frame.left;
    appendVertex(mesh, ball.centre + (ball.diameter / 2.0) * direction, ball.frame.up, 0.5 + 0.5 * std::cos(angle),
                 0.5 + 0.5 * std::sin(angle));
  }
  for (std::uint32_t k = 1; k <= static_cast<std::uint32_t>(sides); ++k) {
    mesh.faces.push_back({centre, centre + k, centre + k + 1, Mesh::kNoVertex});
  }
}

void appendTube(Mesh& mesh, const std::vector<TubeRing>& rings, int sides) {
  if (rings.size() < 2) {
    return;
  }
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(sides);
  for (const TubeRing& ring : rings) {
    for (int k = 0; k <= sides; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k % sides) / sides;
      const Vec3 normal = std::cos(angle) * ring.up + std::sin(angle) * ring.side;
      appendVertex(mesh, ring.centre + ring.radius * normal, normal, static_cast<double>(k) / sides, ring.along);
    }
  }
  appendGridFaces(mesh, first, static_cast<std::uint32_t>(rings.size() - 1), columns);
  // flat ends, with vertices of their own for their normals
  for (const bool isEnd : {false, true}) {
    const TubeRing& ring = isEnd ? rings.back() : rings.front();
    const Vec3 outward = core::cross(ring.up, ring.side) * (isEnd ? 1.0 : -1.0);
    const auto centre = static_cast<std::uint32_t>(mesh.positions.size());
    appendVertex(mesh, ring.centre, outward, 0.5, ring.along);
    for (int k = 0; k <= sides; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k % sides) / sides;
      appendVertex(mesh, ring.centre + ring.radius * (std::cos(angle) * ring.up + std::sin(angle) * ring.side), outward,
                   static_cast<double>(k) / sides, ring.along);
    }
    for (std::uint32_t k = 1; k <= columns; ++k) {
      mesh.faces.push_back(isEnd ? std::array{centre, centre + k, centre + k + 1, Mesh::kNoVertex}
                                 : std::array{centre, centre + k + 1, centre + k, Mesh::kNoVertex});
    }
  }
}

}  // namespace espalier::turtle
