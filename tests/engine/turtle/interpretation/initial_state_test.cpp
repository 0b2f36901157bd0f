// Where a view file lets the turtle start, and its displacement of what is drawn.

#include <cmath>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::initial_state_test {
namespace {

using core::Vec3;

double distance(const Vec3& a, const Vec3& b) {
  return core::length(a - b);
}

TEST(InitialState, TheFirstStepGoesWhereTheViewSays) {
  files::ViewSettings view;
  view.initialPosition = {5.0, 1.0, 0.0};
  view.initialHeading = {1.0, 0.0, 0.0};
  TurtleRun run("F(2)+(90)F(1)", view);
  run.draw();
  ASSERT_EQ(run.scene.segments.size(), 2U);
  EXPECT_EQ(run.scene.segments[0].start, (Vec3{5.0, 1.0, 0.0}));
  EXPECT_LT(distance(run.scene.segments[0].end, {7.0, 1.0, 0.0}), 1e-12);
  // + turns left as before: the up vector is kept in the plane
  EXPECT_LT(distance(run.scene.segments[1].end, {7.0, 2.0, 0.0}), 1e-12);
}

TEST(InitialState, IsInThePlantsOwnCoordinates) {
  files::ViewSettings view;
  view.initialPosition = {1.0, 0.0, 0.0};
  view.initialHeading = {1.0, 0.0, 0.0};
  // a plant that lies: its y is the world's x, and its x the world's -y
  PlantPlacement placement;
  placement.position = {10.0, 0.0, 0.0};
  placement.frame = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, -1.0}};
  TurtleRun run("F(2)", view);
  run.draw(placement);
  EXPECT_LT(distance(run.scene.segments[0].start, {10.0, -1.0, 0.0}), 1e-12);
  EXPECT_LT(distance(run.scene.segments[0].end, {10.0, -3.0, 0.0}), 1e-12);
}

TEST(InitialState, AHeadingOutOfThePlaneKeepsTheFrameOrthogonal) {
  files::ViewSettings view;
  view.initialHeading = {0.0, 0.0, 1.0};
  TurtleRun run("F(1)", view);
  run.draw();
  const core::Frame& frame = run.scene.segments[0].frame;
  EXPECT_LT(std::abs(core::dot(frame.heading, frame.up)), 1e-12);
  EXPECT_LT(distance(core::cross(frame.heading, frame.up), frame.left), 1e-12);
}

TEST(Displacement, MovesEachDrawnStepButNoMove) {
  files::ViewSettings view;
  view.displacement = {0.5, -0.25, 0.0};
  TurtleRun run("F(1)f(1)F(1)", view);
  run.draw();
  ASSERT_EQ(run.scene.segments.size(), 2U);
  EXPECT_EQ(run.scene.segments[0].end, (Vec3{0.5, 0.75, 0.0}));
  EXPECT_EQ(run.scene.segments[1].start, (Vec3{0.5, 1.75, 0.0}));
  EXPECT_EQ(run.scene.segments[1].end, (Vec3{1.0, 2.5, 0.0}));
}

}  // namespace
}  // namespace espalier::turtle::initial_state_test
