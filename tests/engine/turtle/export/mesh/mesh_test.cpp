#include "engine/turtle/export/mesh/mesh.h"

#include <cmath>
#include <limits>

#include "engine/turtle/export/mesh/cylinder_mesh.h"
#include "engine/turtle/export/mesh/tubes.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::mesh_test {
namespace {

TEST(Tubes, ChainsFollowTheAxisAndBranchesBeginTheirOwn) {
  TurtleRun run("F[+F F]F F|F");
  run.draw();
  core::WorkerTeam team(2);
  const SegmentChains chains = chainsOf(run.scene, Palette(run.scene, {}), {}, team);
  // the last one has turned back on itself
  EXPECT_EQ(chains.heads, (std::vector<std::uint32_t>{0, 1, 5}));
  EXPECT_EQ(chains.next, (std::vector<std::uint32_t>{3, 2, kNoParent, 4, kNoParent, kNoParent}));
}

TEST(Tubes, RingsAtJointsHalveTheAngleAndDoNotTwist) {
  TurtleRun run("F+(60)F/(90)F");
  run.draw();
  const Palette palette(run.scene, {});
  core::WorkerTeam team(2);
  const std::vector<TubeRing> rings = tubeOf(run.scene, palette, chainsOf(run.scene, palette, {}, team), 0, {}).rings;
  ASSERT_EQ(rings.size(), 4U);
  const core::Vec3 axis = core::cross(rings[1].normalUp, rings[1].normalSide);
  expectVector(axis, -std::sin(3.14159265358979 / 6.0), std::cos(3.14159265358979 / 6.0), 0, 1e-9);
  // the turtle rolled by 90 degrees before the third segment, the tube does not
  expectVector(rings[3].up, rings[2].up.x, rings[2].up.y, rings[2].up.z, 1e-9);
  EXPECT_NEAR(rings[3].along, 3.0, 1e-12);
}

TEST(Mesh, APatchInterpolatesItsCorners) {
  std::array<core::Vec3, 16> points;
  for (std::size_t i = 0; i < 16; ++i) {
    points[i] = {static_cast<double>(i / 4), static_cast<double>(i % 4), 0.0};
  }
  Mesh mesh;
  appendPatch(mesh, points, 2, 2);
  ASSERT_EQ(mesh.positions.size(), 9U);
  expectVector(mesh.positions[0], 0, 0, 0);
  expectVector(mesh.positions[4], 1.5, 1.5, 0);
  expectVector(mesh.positions[8], 3, 3, 0);
  // dP/dt x dP/ds = y x x = -z
  expectVector(mesh.normals[4], 0, 0, -1);
}

void appendCylinder(Mesh& mesh, const GeneralizedCylinder& cylinder) {
  const SweptCylinder swept(cylinder, {});
  for (const CylinderRun& run : swept.runs()) {
    swept.appendRun(mesh, run);
  }
}

TEST(Mesh, AStraightHermiteCylinderIsACylinder) {
  TurtleRun run("!(2)@!(6)@Gs f(4)@Gc(2)@Ge(1)");
  run.draw();
  ASSERT_EQ(run.scene.cylinders.size(), 1U);
  Mesh mesh;
  appendCylinder(mesh, run.scene.cylinders[0]);
  for (const core::Vec3& p : mesh.positions) {
    EXPECT_NEAR(std::hypot(p.x, p.z), 1.0, 1e-9);
  }
}

TEST(Mesh, ARadiusFollowsItsTangents) {
  // slopes sin 30 at the start and sin -30 at the end over a distance of 4: in the middle 1 + 4 (0.5 + 0.5) / 8 = 1.5
  TurtleRun run("!(2)@Gs@Gr(30,1,-30,1)f(4)@Ge(2)");
  run.draw();
  ASSERT_EQ(run.scene.cylinders.size(), 1U);
  Mesh mesh;
  appendCylinder(mesh, run.scene.cylinders[0]);
  double most = 0.0;
  for (const core::Vec3& p : mesh.positions) {
    most = std::max(most, std::hypot(p.x, p.z));
    EXPECT_GE(std::hypot(p.x, p.z), 1.0 - 1e-9);
  }
  EXPECT_NEAR(most, 1.5, 1e-9);
}

// an open B-spline ends at its end points
TEST(Mesh, AnOpenBSplineCylinderReachesItsEnds) {
  TurtleRun run("!(2){(3)f(1)+(30)f(2)-(30)f(1)}(3)");
  run.draw();
  Mesh mesh;
  appendCylinder(mesh, run.scene.cylinders[0]);
  core::Vec3 first;
  core::Vec3 last;
  for (std::size_t k = 0; k < 8; ++k) {
    first = first + mesh.positions[k] * 0.125;
    last = last + mesh.positions[mesh.positions.size() - 16 - 9 + k] * 0.125;  // two caps of 8 follow
  }
  expectVector(first, 0, 0, 0);
  expectVector(last, -1, 2.0 + 2.0 * std::cos(3.14159265358979 / 6.0), 0, 1e-4);
}

TEST(Mesh, ContoursAreSampledAtEqualDistancesFromPlusX) {
  files::ViewSettings view;
  // a closed square of control points: its B-spline is symmetric
  view.contours.push_back({.id = 4, .isClosed = true, .points = {{0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 0}}});
  const std::vector<core::Vec3> samples = sampleContour(view, 4, 8);
  ASSERT_EQ(samples.size(), 9U);
  EXPECT_NEAR(samples[0].y, 0.0, 1e-12);
  EXPECT_GT(samples[0].x, 0.0);
  expectVector(samples[8], samples[0].x, samples[0].y, 0, 1e-9);
  EXPECT_NEAR(samples[4].x, -samples[0].x, 1e-6);
  // an unknown contour is the circle
  expectVector(sampleContour(view, 9, 4)[1], 0, 1, 0);
}

TEST(Mesh, APatchWhoseEdgeHasShrunkToAPointHasNormalsThere) {
  // a leaf: the last row of control points is its tip
  std::array<core::Vec3, 16> points;
  for (std::size_t i = 0; i < 16; ++i) {
    const auto row = static_cast<double>(i / 4);
    points[i] = {(static_cast<double>(i % 4) - 1.5) * (i / 4 == 3 ? 0.0 : 1.0), row, 0.0};
  }
  Mesh mesh;
  appendPatch(mesh, points, 3, 3);
  for (const core::Vec3& normal : mesh.normals) {
    EXPECT_NEAR(std::abs(normal.z), 1.0, 1e-6);
  }
}

TEST(Mesh, FacesWithoutAreaAreDroppedAtEachScale) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr std::uint32_t kNone = Mesh::kNoVertex;
  struct Case {
    const char* name;
    std::vector<std::array<double, 2>> corners;
    std::vector<std::array<std::uint32_t, 4>> kept;
  };
  // a triangle is flat at a height of a millionth of its longest side, two corners are one at a ten-millionth
  const std::vector<Case> cases{
      {"low triangle", {{0, 0}, {1, 0}, {0.5, 2e-6}}, {{0, 1, 2, kNone}}},
      {"triangle just above the bound", {{0, 0}, {1, 0}, {0.5, 1.01e-6}}, {{0, 1, 2, kNone}}},
      {"flat triangle", {{0, 0}, {1, 0}, {0.5, 0.99e-6}}, {}},
      {"triangle of a point", {{1, 1}, {1, 1}, {1, 1}}, {}},
      {"triangle with two corners at one place", {{0, 0}, {1, 0}, {1, 0}}, {}},
      {"square", {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2, 3}}},
      {"strip", {{0, 0}, {1, 0}, {1, 2e-6}, {0, 2e-6}}, {{0, 1, 2, 3}}},
      {"flat strip", {{0, 0}, {1, 0}, {1, 0.9e-6}, {0, 0.9e-6}}, {}},
      {"last corner on the diagonal", {{0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}}, {{0, 1, 2, kNone}}},
      {"second corner on the diagonal", {{0, 0}, {0.5, 0.5}, {1, 1}, {0, 1}}, {{0, 2, 3, kNone}}},
      {"last corner near the first", {{0, 0}, {1, 0}, {1, 1}, {0, 3e-6}}, {{0, 1, 2, 3}}},
      {"last corner at the first", {{0, 0}, {1, 0}, {1, 1}, {0, 1e-7}}, {{0, 1, 2, kNone}}},
      {"last corner is no number", {{0, 0}, {1, 0}, {1, 1}, {0, kNaN}}, {{0, 1, 2, kNone}}},
      {"second corner is no number", {{0, 0}, {1, kNaN}, {1, 1}, {0, 1}}, {{0, 2, 3, kNone}}},
      {"triangle with a corner that is no number", {{0, 0}, {1, 0}, {0, kNaN}}, {}},
  };
  for (const double scale : {1.0, 1e-60, 1e60}) {
    for (const Case& test : cases) {
      Mesh mesh;
      for (const auto& [x, y] : test.corners) {
        mesh.positions.push_back({scale * x, scale * y, 0.0});
      }
      mesh.faces.push_back({0, 1, 2, test.corners.size() == 4 ? 3 : kNone});
      dropDegenerateFaces(mesh);
      EXPECT_EQ(mesh.faces, test.kept) << test.name << ", scale " << scale;
    }
  }
}

TEST(Mesh, CornersAtAlmostOnePlaceComeToLieAtOne) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1e-7, 0}};
  mesh.faces.push_back({0, 1, 2, 3});
  dropDegenerateFaces(mesh);
  EXPECT_EQ(mesh.positions[3], mesh.positions[0]);
  mesh.positions[3] = {0, 3e-7, 0};
  mesh.faces = {{0, 1, 2, 3}};
  dropDegenerateFaces(mesh);
  EXPECT_EQ(mesh.positions[3], (core::Vec3{0, 3e-7, 0}));
}

TEST(Mesh, PatchesOfASurfaceThatMeetShareTheirNormals) {
  files::Surface surface;
  surface.subdivisionS = surface.subdivisionT = 2;
  for (const double sign : {1.0, -1.0}) {
    files::SurfacePatch patch;
    for (std::size_t i = 0; i < 16; ++i) {
      const double across = static_cast<double>(i / 4) / 3.0;
      // a shallow roof over the edge x = 0
      patch.points[i] = {sign * across, static_cast<double>(i % 4) * sign, -0.3 * across};
    }
    surface.patches.push_back(patch);
  }
  Mesh mesh;
  appendLocalSurface(mesh, surface);
  std::size_t met = 0;
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t k = 9; k < 18; ++k) {
      if (mesh.positions[i] == mesh.positions[k]) {
        ++met;
        EXPECT_EQ(mesh.normals[i], mesh.normals[k]);
        EXPECT_NEAR(std::abs(mesh.normals[i].z), 1.0, 1e-9);
      }
    }
  }
  EXPECT_EQ(met, 1U) << "only the corner at the origin is common";
}

}  // namespace
}  // namespace espalier::turtle::mesh_test
