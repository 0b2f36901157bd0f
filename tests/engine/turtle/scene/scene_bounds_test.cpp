#include "engine/turtle/scene/scene_bounds.h"

#include <gtest/gtest.h>

namespace espalier::turtle::scene_bounds_test {
namespace {

using core::Vec3;

TEST(SceneBounds, OfNothingAreNone) {
  EXPECT_FALSE(boundsOf(Scene{}, {}));
}

TEST(SceneBounds, HoldEveryKindOfThing) {
  Scene scene;
  scene.segments.push_back({});
  scene.segments[0].end = {0.0, 2.0, 0.0};
  Ball& ball = scene.balls.emplace_back();
  ball.centre = {3.0, 0.0, 0.0};
  ball.diameter = 2.0;
  Polygon polygon;
  polygon.vertices = {{0.0, 0.0, -7.0}};
  scene.polygons.push_back(polygon);
  scene.labels.emplace_back().position = {0.0, 9.0, 0.0};
  GeneralizedCylinder cylinder;
  cylinder.points.resize(2);
  cylinder.points[1].position = {-4.0, 0.0, 0.0};
  scene.cylinders.push_back(cylinder);
  Patch patch;
  patch.points[5] = {0.0, -3.0, 0.0};
  scene.patches.push_back(patch);
  files::ViewSettings view;
  files::Surface surface;
  surface.patches.emplace_back();
  surface.patches[0].points.fill(Vec3{0.0, 0.0, 0.0});
  view.surfaces.push_back(surface);
  scene.surfaces.emplace_back().position = {0.0, 0.0, 8.0};

  const auto box = boundsOf(scene, view);
  ASSERT_TRUE(box);
  EXPECT_NEAR(core::length(box->minimum - Vec3{-4.0, -3.0, -7.0}), 0.0, 1e-12);
  EXPECT_NEAR(core::length(box->maximum - Vec3{4.0, 9.0, 8.0}), 0.0, 1e-12);
}

}  // namespace
}  // namespace espalier::turtle::scene_bounds_test
