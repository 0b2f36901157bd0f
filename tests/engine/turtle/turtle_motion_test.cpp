#include "engine/turtle/turtle_motion.h"

#include <cmath>
#include <numbers>

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::turtle_motion_test {
namespace {

constexpr double kQuarter = std::numbers::pi / 2.0;

// docs/language.md, Turtle interpretation: each turn by 90 degrees from the initial frame
TEST(TurtleMotion, TurnLeftFromTheInitialFrame) {
  core::Frame frame;
  turnLeft(frame, kQuarter);
  expectVector(frame.heading, -1, 0, 0);
  expectVector(frame.left, 0, -1, 0);
  expectVector(frame.up, 0, 0, -1);
}

TEST(TurtleMotion, PitchDownFromTheInitialFrame) {
  core::Frame frame;
  pitchDown(frame, kQuarter);
  expectVector(frame.heading, 0, 0, -1);
  expectVector(frame.up, 0, -1, 0);
  expectVector(frame.left, -1, 0, 0);
}

TEST(TurtleMotion, RollRightFromTheInitialFrame) {
  core::Frame frame;
  rollRight(frame, kQuarter);
  expectVector(frame.left, 0, 0, -1);
  expectVector(frame.up, 1, 0, 0);
  expectVector(frame.heading, 0, 1, 0);
}

TEST(TurtleMotion, CachedTurnsHaveTheSameBits) {
  TurnCache cache;
  // more angles than the cache has places, twice, and both zeros
  for (int round = 0; round < 2; ++round) {
    for (int i = -200; i <= 200; ++i) {
      const double radians = 0.0173 * i;
      const Turn& turn = cache.turnBy(radians);
      EXPECT_EQ(turn.cosine, core::cos(radians)) << i;
      EXPECT_EQ(turn.sine, core::sin(radians)) << i;
    }
  }
  EXPECT_FALSE(std::signbit(cache.turnBy(0.0).sine));
  EXPECT_TRUE(std::signbit(cache.turnBy(-0.0).sine));
}

TEST(TurtleMotion, EveryTurnKeepsTheLeftHandedFrame) {
  core::Frame frame;
  turnLeft(frame, 0.3);
  pitchDown(frame, -1.1);
  rollRight(frame, 2.2);
  turnAround(frame);
  const core::Vec3 left = core::cross(frame.heading, frame.up);
  expectVector(frame.left, left.x, left.y, left.z, 1e-12);
  EXPECT_NEAR(core::length(frame.up), 1.0, 1e-12);
}

TEST(TurtleMotion, TransportAcrossAQuarterTurnCarriesTheUpVector) {
  // from +y to +z the rotation is about +x by 90 degrees: -z goes to +y, +x stays
  expectVector(transported({0, 0, -1}, {0, 1, 0}, {0, 0, 1}), 0, 1, 0, 1e-12);
  expectVector(transported({1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1, 0, 0, 1e-12);
}

TEST(TurtleMotion, TransportToTheOppositeHeadingKeepsTheUpVector) {
  expectVector(transported({1, 0, 0}, {0, 1, 0}, {0, -1, 0}), 1, 0, 0, 1e-12);
}

TEST(TurtleMotion, RotatedAboutFollowsTheRightHand) {
  expectVector(rotatedAbout({1, 0, 0}, {0, 0, 1}, kQuarter), 0, 1, 0, 1e-12);
}

TEST(TurtleMotion, RollToVerticalKeepsAVerticalHeading) {
  core::Frame frame;
  rollRight(frame, 0.7);
  const core::Frame before = frame;
  rollToVertical(frame);
  EXPECT_EQ(frame, before);
}

TEST(TurtleMotion, SetHeadingTakesAnExactlyPerpendicularUpVectorOnly) {
  TurtleState state;
  setHeading(state, {2, 0, 0}, {0, 0, 5});
  expectVector(state.frame.up, 0, 0, 1, 1e-12);
  expectVector(state.frame.left, 0, -1, 0, 1e-12);
  // not perpendicular: transported from the initial frame instead
  setHeading(state, {2, 0, 0}, {0.1, 0, 5});
  expectVector(state.frame.up, 0, 0, -1, 1e-12);
}

TEST(TurtleMotion, SetHeadingOfZeroPointsUp) {
  TurtleState state;
  setHeading(state, {0, 0, 0});
  expectVector(state.frame.heading, 0, 1, 0, 1e-12);
}

// recorded: the start and the frame after +(90), then &(30)
TEST(TurtleMotion, QuaternionOfTheInitialFrameAndItsTurns) {
  core::Frame frame;
  const auto start = quaternionOf(frame);
  EXPECT_NEAR(start[0], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(start[1], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(start[2], 0.0, 1e-12);
  EXPECT_NEAR(start[3], 0.0, 1e-12);
  turnLeft(frame, kQuarter);
  EXPECT_NEAR(quaternionOf(frame)[0], 1.0, 1e-12);
  pitchDown(frame, std::numbers::pi / 6.0);
  EXPECT_NEAR(quaternionOf(frame)[0], 0.965926, 1e-6);
  EXPECT_NEAR(quaternionOf(frame)[2], -0.258819, 1e-6);
}

// the branches of the algorithm for matrices the turtle can have: trace above -1, and U alone at +z
TEST(TurtleMotion, QuaternionOfOtherFrames) {
  const core::Frame turned{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  const auto q = quaternionOf(turned);
  EXPECT_NEAR(q[3], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(q[1], (1.0 - 1.0) / (4.0 * q[3]), 1e-12);
  const core::Frame third{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  EXPECT_NEAR(quaternionOf(third)[2], 1.0, 1e-12);
  const core::Frame second{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}};
  EXPECT_NEAR(quaternionOf(second)[1], 1.0, 1e-12);
}

}  // namespace
}  // namespace espalier::turtle::turtle_motion_test
