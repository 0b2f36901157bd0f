#include "environment/obstacles/obstacle_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "environment/obstacles/scene_file.h"

namespace espalier::environment::obstacle_scene_test {
namespace {

using core::Vec3;

/// A cube from −1 to 1 as a mesh; `turn` faces its triangles inwards.
MeshData cube(bool turn = false) {
  auto read = readScene("translate -1 -1 -1 box 2 2 2");
  MeshData mesh = read.value().meshes.at(0);
  for (auto& triangle : mesh.triangles) {
    if (turn) {
      std::swap(triangle[0], triangle[1]);
    }
  }
  return mesh;
}

ObstacleScene sceneOf(MeshData mesh) {
  return ObstacleScene({{}, {}, {}, {}, {std::move(mesh)}});
}

TEST(ObstacleScene, AMeshAnswersAsTheBoxItIs) {
  // the same cube as twelve triangles and as a box: distances, insides and rays agree everywhere
  const ObstacleScene box({{}, {{{-1, -1, -1}, {1, 1, 1}}}, {}, {}, {}});
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> place(-3, 3);
  for (const bool turn : {false, true}) {
    const ObstacleScene mesh = sceneOf(cube(turn));
    for (int i = 0; i < 500; ++i) {
      const Vec3 p{place(random), place(random), place(random)};
      const Vec3 q{place(random), place(random), place(random)};
      const auto a = box.nearest(p, 10);
      const auto b = mesh.nearest(p, 10);
      ASSERT_TRUE(a && b);
      ASSERT_NEAR(a->distance, b->distance, 1e-12) << p.x << " " << p.y << " " << p.z;
      ASSERT_EQ(box.isInside(p), mesh.isInside(p));
      ASSERT_NEAR(core::length(a->point - b->point), 0.0, 1e-12);
      ASSERT_NEAR(core::length(a->normal - b->normal), 0.0, 1e-9);
      const Vec3 direction = core::normalised(q - p);
      ASSERT_NEAR(box.clearance(p, direction, 20), mesh.clearance(p, direction, 20), 1e-9);
      ASSERT_EQ(box.isClear(p, q, 0.1), mesh.isClear(p, q, 0.1));
    }
  }
}

TEST(ObstacleScene, DistancesOfCapsulesAreThoseOfTheirAxes) {
  // axes crossing at right angles at distance 3, radii 0.5 and 1: 1.5 between the surfaces
  const ObstacleScene scene({{}, {}, {}, {{{-5, 0, 0}, {5, 0, 0}, 1.0}}, {}});
  EXPECT_TRUE(scene.isClear({0, 3, -4}, {0, 3, 4}, 1.999));
  EXPECT_FALSE(scene.isClear({0, 3, -4}, {0, 3, 4}, 2.001));
  // beyond its end it is a ball: from (8, 4, 0) to (5, 0, 0) are 5
  EXPECT_NEAR(scene.nearest({8, 4, 0}, 10)->distance, 4.0, 1e-15);
  EXPECT_FALSE(scene.nearest({8, 4, 0}, 3.9).has_value());
  EXPECT_NEAR(scene.clearance({2, 7, 0}, {0, -1, 0}, 100), 6.0, 1e-12);
  EXPECT_NEAR(scene.clearance({5.6, 7, 0}, {0, -1, 0}, 100), 7.0 - 0.8, 1e-12);
  EXPECT_EQ(scene.clearance({2, 0.5, 0}, {0, -1, 0}, 100), 0.0);
  EXPECT_EQ(scene.clearance({2, 7, 0}, {0, 1, 0}, 100), 100.0);
}

TEST(ObstacleScene, EverythingIsAskedTogether) {
  const ObstacleScene scene({{{{0, 0, 0}, {0, 1, 0}}}, {{{4, 0, -1}, {6, 2, 1}}}, {{{0, 5, 0}, 1.0}}, {}, {}});
  EXPECT_NEAR(scene.nearest({0, 2, 0}, 10)->distance, 2.0, 1e-15);
  EXPECT_NEAR(scene.nearest({0, 3.5, 0}, 10)->distance, 0.5, 1e-15);
  EXPECT_NEAR(scene.nearest({0, -3, 0}, 10)->distance, -3.0, 1e-15);
  EXPECT_TRUE(scene.isInside({5, 1, 0}));
  EXPECT_FALSE(scene.isClear({0, 2, 0}, {0, 4.5, 0}, 0.1));
  EXPECT_FALSE(scene.isClear({2, 1, 0}, {3.95, 1, 0}, 0.1));
  EXPECT_TRUE(scene.isClear({2, 1, 0}, {3.85, 1, 0}, 0.1));
  EXPECT_TRUE(ObstacleScene({}).isClear({0, 0, 0}, {9, 9, 9}, 99));
}

TEST(ObstacleScene, AHeightFieldIsSolidBelow) {
  MeshData ground;
  ground.isGround = true;
  ground.vertices = {{0, 0, 0}, {10, 10, 0}, {0, 0, 10}, {10, 10, 10}};
  ground.triangles = {{0, 2, 3}, {0, 3, 1}};
  const ObstacleScene scene = sceneOf(ground);
  // a plane y = x: a point 1 above it is 1/√2 away
  EXPECT_NEAR(scene.nearest({5, 6, 5}, 10)->distance, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(scene.nearest({5, 4, 5}, 10)->distance, -std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(scene.isInside({5, -50, 5}));
  EXPECT_FALSE(scene.isInside({5, -50, 15}));
  EXPECT_NEAR(scene.clearance({5, 9, 5}, {0, -1, 0}, 100), 4.0, 1e-12);
}

TEST(ObstacleScene, TrianglesOfAClosedMeshMayFaceAnyWay) {
  std::mt19937 random(2);
  for (std::uint_fast32_t turned = 0; turned < (1U << 12U); turned += 1 + random() % 64) {
    MeshData mesh = cube();
    ASSERT_EQ(mesh.triangles.size(), 12U);
    for (std::size_t i = 0; i < 12; ++i) {
      if ((turned >> i & 1U) != 0) {
        std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
      }
    }
    const ObstacleScene scene = sceneOf(mesh);
    ASSERT_EQ(scene.nearest({0.5, 0, 0}, 1)->distance, -0.5) << turned;
    ASSERT_EQ(scene.nearest({0.5, 0, 0}, 1)->normal, (Vec3{1, 0, 0})) << turned;
    ASSERT_EQ(scene.nearest({0, 1.5, 0}, 1)->distance, 0.5) << turned;
    ASSERT_EQ(scene.nearest({0, 1.5, 0}, 1)->normal, (Vec3{0, 1, 0})) << turned;
  }
}

TEST(ObstacleScene, AOneSidedMeshHasNoInside) {
  // the projective plane of six vertices: each side belongs to two triangles, and they cannot all face one way
  MeshData mesh;
  mesh.vertices = {{0, 1, 0}, {1, 0, 0}, {-1, 0, 0.5}, {0, -1, 0}, {0, 0, 1}, {0.2, 0, -1}};
  mesh.triangles = {{0, 1, 4}, {0, 1, 5}, {0, 2, 3}, {0, 2, 5}, {0, 3, 4},
                    {1, 2, 3}, {1, 2, 4}, {1, 3, 5}, {2, 4, 5}, {3, 4, 5}};
  EXPECT_FALSE(ObstacleMesh(mesh).isClosed());
  EXPECT_FALSE(sceneOf(mesh).isInside({0.1, 0.1, 0.1}));
}

TEST(ObstacleScene, AMeshWithHolesHasNoInside) {
  MeshData open = cube();
  open.triangles.pop_back();
  const ObstacleScene scene = sceneOf(open);
  EXPECT_FALSE(scene.isInside({0, 0, 0}));
  EXPECT_NEAR(scene.nearest({0, 0.5, 0}, 10)->distance, 0.5, 1e-12);
}

TEST(ObstacleScene, FarFromTheOriginNothingIsLost) {
  // single precision has 0.06 between its numbers at 10^6: boxes must be widened by more
  const Vec3 far{1e6, -1e6, 1e6};
  const ObstacleScene scene({{}, {}, {{far, 0.25}}, {}, {}});
  EXPECT_NEAR(scene.nearest(far + Vec3{0.5, 0, 0}, 0.3)->distance, 0.25, 1e-9);
  EXPECT_NEAR(scene.clearance(far + Vec3{0, 100, 0}, {0, -1, 0}, 1000), 99.75, 1e-9);
  EXPECT_NEAR(scene.clearance({1e6, 1e6, 1e6}, {0, -1, 0}, 1e7), 2e6 - 0.25, 1e-6);
}

TEST(SceneFile, ReadsShapesWithTheirMatrices) {
  const auto read = readScene(
      "// a comment\npushmatrix translate 1 2 3 rotate 90 0 0 1 scale 2 2 2\nsphere 0.5 /* a ball */\npopmatrix\n"
      "cylinder 1 4\nscale 1 2 1 sphere 1\nmaterial 0 0 1\nrectangle 2 3");
  ASSERT_TRUE(read.has_value());
  const SceneShapes& shapes = *read;
  ASSERT_EQ(shapes.spheres.size(), 1U);
  EXPECT_NEAR(core::length(shapes.spheres[0].centre - Vec3{1, 2, 3}), 0.0, 1e-12);
  EXPECT_NEAR(shapes.spheres[0].radius, 1.0, 1e-12);
  ASSERT_EQ(shapes.meshes.size(), 3U);
  const ObstacleMesh cylinder(shapes.meshes[0]);
  EXPECT_TRUE(cylinder.isClosed());
  EXPECT_TRUE(cylinder.isInside({0.9, 3.9, 0}));
  EXPECT_FALSE(cylinder.isInside({0.9, 4.1, 0}));
  const ObstacleMesh ellipsoid(shapes.meshes[1]);
  EXPECT_TRUE(ellipsoid.isClosed());
  EXPECT_TRUE(ellipsoid.isInside({0, 1.9, 0}));
  EXPECT_FALSE(ellipsoid.isInside({1.9, 0, 0}));
  EXPECT_FALSE(ObstacleMesh(shapes.meshes[2]).isClosed());
}

TEST(SceneFile, SaysWhichLineLacksNumbers) {
  const auto read = readScene("sphere 1\n\nbox 1 2\n");
  EXPECT_EQ(read.error(), "line 3: 'box' needs 3 numbers, found 2 numbers");
}

TEST(SceneFile, EveryEncodingOfAModelIsRead) {
  EXPECT_EQ(readScene("\xEF\xBB\xBFsphere 1\r// two\rsphere 2\r")->spheres.size(), 2U);
}

}  // namespace
}  // namespace espalier::environment::obstacle_scene_test
