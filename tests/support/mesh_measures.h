#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::test {

/// The measures of a mesh when vertices at exactly the same place are one.
struct MeshMeasures {
  std::size_t triangleCount = 0;  // without those that have two corners at the same place
  std::size_t openEdgeCount = 0;  // edges that do not have exactly one triangle on each side
  double area = 0.0;
  double signedVolume = 0.0;        // positive when a closed mesh looks outward
  double smallestFacing = 1.0;      // least cosine between a triangle's side and the mean normal of its corners
  double largestNormalError = 0.0;  // of |normal| - 1
  core::Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
};

inline MeshMeasures measure(const turtle::Mesh& mesh) {
  using core::Vec3;
  MeshMeasures measures;
  std::map<std::tuple<double, double, double>, std::uint32_t> places;
  std::vector<std::uint32_t> place;
  for (const Vec3& p : mesh.positions) {
    const auto key = std::tuple(p.x + 0.0, p.y + 0.0, p.z + 0.0);
    place.push_back(places.emplace(key, static_cast<std::uint32_t>(places.size())).first->second);
    measures.low = {std::min(measures.low.x, p.x), std::min(measures.low.y, p.y), std::min(measures.low.z, p.z)};
    measures.high = {std::max(measures.high.x, p.x), std::max(measures.high.y, p.y), std::max(measures.high.z, p.z)};
  }
  for (const Vec3& n : mesh.normals) {
    measures.largestNormalError = std::max(measures.largestNormalError, std::abs(core::length(n) - 1.0));
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<int, int>> edges;  // there, back
  const auto addTriangle = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const std::array<std::uint32_t, 3> corner{place[i], place[j], place[k]};
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
      return;
    }
    ++measures.triangleCount;
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t a = corner[e];
      const std::uint32_t b = corner[(e + 1) % 3];
      auto& [there, back] = edges[{std::min(a, b), std::max(a, b)}];
      ++(a < b ? there : back);
    }
    const Vec3 side = core::cross(mesh.positions[j] - mesh.positions[i], mesh.positions[k] - mesh.positions[i]);
    measures.area += 0.5 * core::length(side);
    measures.signedVolume += core::dot(mesh.positions[i], core::cross(mesh.positions[j], mesh.positions[k])) / 6.0;
    if (core::length(side) > 1e-9) {
      const Vec3 normal = mesh.normals[i] + mesh.normals[j] + mesh.normals[k];
      measures.smallestFacing =
          std::min(measures.smallestFacing, core::dot(core::normalised(side), core::normalised(normal)));
    }
  };
  for (const auto& face : mesh.faces) {
    addTriangle(face[0], face[1], face[2]);
    if (face[3] != turtle::Mesh::kNoVertex) {
      addTriangle(face[0], face[2], face[3]);
    }
  }
  for (const auto& [edge, count] : edges) {
    measures.openEdgeCount += count.first == 1 && count.second == 1 ? 0U : 1U;
  }
  return measures;
}

}  // namespace espalier::test
