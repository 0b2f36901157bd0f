#include "engine/files/surfaces/background_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace espalier::files::background_scene_test {
namespace {

using core::Vec3;

BackgroundScene sceneOf(std::string_view text) {
  std::vector<BackgroundProblem> problems;
  BackgroundScene scene = readBackgroundScene(text, problems);
  EXPECT_TRUE(problems.empty()) << (problems.empty() ? "" : problems.front().message);
  return scene;
}

// by the divergence theorem: a sixth of the sum of the triple products of the triangles' corners
double volumeOf(const BackgroundShape& shape) {
  double sum = 0.0;
  for (const auto& [a, b, c] : shape.triangles) {
    sum += core::dot(shape.vertices[a], core::cross(shape.vertices[b], shape.vertices[c]));
  }
  return std::abs(sum) / 6.0;
}

TEST(BackgroundScene, SolidsHaveTheirVolumes) {
  const BackgroundScene scene =
      sceneOf("prism 2 3 4 box 1 1 1 cylinder 2 5 cone 2 0 3 pushmatrix scale 1 2 3 sphere 1");
  ASSERT_EQ(scene.shapes.size(), 5U);
  EXPECT_NEAR(volumeOf(scene.shapes[0]), 24.0, 1e-12);
  EXPECT_NEAR(volumeOf(scene.shapes[1]), 1.0, 1e-12);
  // a prism of 32 sides has the area 16 sin(2 pi / 32) r^2
  const double area = 16.0 * std::sin(std::numbers::pi / 16.0);
  EXPECT_NEAR(volumeOf(scene.shapes[2]), area * 4.0 * 5.0, 1e-9);
  EXPECT_NEAR(volumeOf(scene.shapes[3]), area * 4.0 * 3.0 / 3.0, 1e-9);
  EXPECT_NEAR(volumeOf(scene.shapes[4]), 6.0 * 4.0 / 3.0 * std::numbers::pi, 1.0);
}

TEST(BackgroundScene, TheNewestMatrixActsFirst) {
  // translate, then turn: the point (1, 0, 0) is turned to (0, 1, 0) and then moved
  const BackgroundScene scene = sceneOf(
      "pushmatrix translate 10 0 0 rotate 90 0 0 1 pushmatrix translate 1 0 0 sphere 2 popmatrix scale 3 3 3 sphere 1 "
      "popmatrix sphere 1 multmatrix 2 0 0 0 0 2 0 0 0 0 2 0 5 6 7 1 sphere 1");
  ASSERT_EQ(scene.shapes.size(), 4U);
  EXPECT_NEAR(core::length(scene.shapes[0].centre - Vec3{10, 1, 0}), 0.0, 1e-12);
  EXPECT_NEAR(core::length(scene.shapes[1].centre - Vec3{10, 0, 0}), 0.0, 1e-12);
  EXPECT_NEAR(scene.shapes[1].radius, 3.0, 1e-12);
  EXPECT_EQ(scene.shapes[2].centre, (Vec3{0, 0, 0}));
  EXPECT_EQ(scene.shapes[3].centre, (Vec3{5, 6, 7}));
  EXPECT_EQ(scene.shapes[3].radius, 2.0);
}

TEST(BackgroundScene, FlatShapesHaveTheirCorners) {
  const BackgroundScene scene = sceneOf(
      "polygon 0 0 0, 1 0 0, 1 1 0, 0 1 0\nmesh 0 0 0 0 1 0 1 0 0 1 1 0 2 0 0 2 1 0\nrectangle 2 3 -1 -1 0.5\n"
      "polygonuv 0 0 0 0 0 1 1 0 0 0 0 1 0 1 0 0 0 1");
  ASSERT_EQ(scene.shapes.size(), 4U);
  EXPECT_EQ(scene.shapes[0].triangles.size(), 2U);
  EXPECT_EQ(scene.shapes[1].triangles,
            (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}}));
  EXPECT_EQ(scene.shapes[2].vertices[2], (Vec3{1, 2, 0}));
  EXPECT_EQ(scene.shapes[3].vertices[2], (Vec3{0, 1, 0}));
}

TEST(BackgroundScene, CompleteGroupsOfAMaterialCount) {
  const BackgroundScene scene = sceneOf(
      "sphere 1 material .1 .2 .3 1 .4 .5 .6 .5 .7 .8 sphere 1 "
      "material 0 0 0 1 1 1 1 1 .5 .5 .5 1 .1 .1 .1 1 30 sphere 1");
  ASSERT_EQ(scene.materials.size(), 3U);
  EXPECT_EQ(scene.shapes[1].material, 1U);
  const Material& first = scene.materials[1];
  EXPECT_EQ(first.ambient, (std::array{0.1, 0.2, 0.3}));
  EXPECT_EQ(first.diffuse, (std::array{0.4, 0.5, 0.6}));
  EXPECT_EQ(first.specular, (std::array{0.0, 0.0, 0.0}));
  EXPECT_EQ(first.opacity, 0.5);
  EXPECT_EQ(scene.materials[2].emission, (std::array{0.1, 0.1, 0.1}));
  EXPECT_EQ(scene.materials[2].shininess, 30.0);
  EXPECT_EQ(scene.materials[2].opacity, 1.0);
}

TEST(BackgroundScene, WhatIsSkippedIsNamedWithItsPlace) {
  std::vector<BackgroundProblem> problems;
  const BackgroundScene scene =
      readBackgroundScene("// a hill\nloadidentity\nprism 1 2\n/* more\n*/ sphere -1 sphere 2 material 1 1", problems);
  EXPECT_EQ(scene.shapes.size(), 1U);
  ASSERT_EQ(problems.size(), 3U);
  EXPECT_TRUE(problems[0].isUnknown);
  EXPECT_EQ(problems[0].message, "unknown keyword 'loadidentity'");
  EXPECT_EQ(problems[1].message, "'prism' needs 3 numbers, found 2 numbers");
  EXPECT_EQ(problems[1].line, 3U);
  EXPECT_EQ(problems[1].range.begin, 23U);
  EXPECT_EQ(problems[2].message, "'sphere' needs a radius that is not negative, found -1");
  EXPECT_EQ(problems[2].line, 5U);
  // a material without a complete group changes nothing
  EXPECT_EQ(scene.materials.size(), 1U);
}

TEST(BackgroundScene, CornersAreBounded) {
  std::string text = "scale 1 2 1\n";
  for (int i = 0; i < 7000; ++i) {
    text += "sphere 1\n";
  }
  std::vector<BackgroundProblem> problems;
  EXPECT_LT(readBackgroundScene(text, problems).shapes.size(), 7000U);
  ASSERT_FALSE(problems.empty());
  EXPECT_EQ(problems[0].message, "'sphere' needs a scene with fewer corners");
}

}  // namespace
}  // namespace espalier::files::background_scene_test
