#include "engine/turtle/export/mesh/polygon_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/mesh_measures.h"

namespace espalier::turtle::polygon_mesh_test {
namespace {

using core::Vec3;

std::vector<Vec3> star(int points, double inner) {
  std::vector<Vec3> polygon;
  for (int k = 0; k < 2 * points; ++k) {
    const double angle = std::numbers::pi * k / points;
    const double radius = k % 2 == 0 ? 1.0 : inner;
    polygon.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  }
  return polygon;
}

TEST(PolygonMesh, WithoutAnAreaItHasSomeNormal) {
  Mesh mesh;
  appendPolygon(mesh, std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}});
  EXPECT_EQ(mesh.faces.size(), 2U);
  EXPECT_EQ(mesh.normals[0], (Vec3{0, 1, 0}));
}

TEST(PolygonMesh, TheNormalLooksFromWhereTheCornersRunCounterClockwise) {
  Mesh mesh;
  appendPolygon(mesh, star(6, 0.5));
  EXPECT_EQ(mesh.normals[0], (Vec3{0, 0, 1}));
  const test::MeshMeasures measures = test::measure(mesh);
  EXPECT_NEAR(measures.smallestFacing, 1.0, 1e-12);
  for (const auto& uv : mesh.coordinates) {
    EXPECT_GE(std::min(uv[0], uv[1]), 0.0);
    EXPECT_LE(std::max(uv[0], uv[1]), 1.0);
  }
}

TEST(PolygonMesh, FewerThanThreeCornersAreNothing) {
  Mesh mesh;
  appendPolygon(mesh, std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}});
  EXPECT_TRUE(mesh.positions.empty());
}

}  // namespace
}  // namespace espalier::turtle::polygon_mesh_test
