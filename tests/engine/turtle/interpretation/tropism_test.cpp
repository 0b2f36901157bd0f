#include "engine/turtle/interpretation/tropism.h"

#include <cmath>

#include "engine/turtle/turtle_motion.h"
#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::tropism_test {
namespace {

files::Movement tropism(core::Vec3 direction, double elasticity, double angle = 0.0) {
  return {.kind = files::Movement::Kind::Tropism,
          .direction = direction,
          .angleDegrees = angle,
          .elasticity = elasticity,
          .elasticityStep = 0.05};
}

TEST(Tropism, TurnsTheHeadingTowardTheDirectionByTheCrossProduct) {
  // H = +y, T = +x, e = 0.2: |H x E| = 0.2 radians toward +x
  TurtleState state;
  state.elasticity[0] = 0.2;
  const std::vector<files::Movement> movements{tropism({1, 0, 0}, 0.2)};
  applyMovements(state, movements);
  expectVector(state.frame.heading, std::sin(0.2), std::cos(0.2), 0, 1e-12);
  expectVector(state.frame.up, 0, 0, -1, 1e-12);
}

TEST(Tropism, TurnsAtMostOneRadian) {
  TurtleState state;
  state.elasticity[0] = 50.0;
  const std::vector<files::Movement> movements{tropism({1, 0, 0}, 50.0)};
  applyMovements(state, movements);
  expectVector(state.frame.heading, std::sin(1.0), std::cos(1.0), 0, 1e-12);
}

TEST(Tropism, AlignedDirectionChangesNothing) {
  TurtleState state;
  state.elasticity[0] = 0.5;
  const std::vector<files::Movement> movements{tropism({0, 1, 0}, 0.5)};
  applyMovements(state, movements);
  EXPECT_EQ(state.frame, core::Frame{});
}

// recorded: &(80)/(30)F with a tropism toward +y, elasticity 0.15
TEST(Tropism, RecordedBendOfASegment) {
  files::ViewSettings view;
  view.movements.push_back(tropism({0, 1, 0}, 0.15));
  TurtleRun run("&(80)/(30)F?P(0,0,0)", view);
  run.pass();
  expectParameters(run.lastParameters(), {0, 0.316705, -0.948524});
}

// recorded: two tropisms add, one of them across its direction
TEST(Tropism, RecordedDiatropismAndSum) {
  files::ViewSettings view;
  view.movements.push_back(tropism({0, 1, 0}, 0.2, 90.0));
  view.movements.push_back(tropism({1, 0, 0}, 0.05));
  TurtleRun run("&(30)F?H(0,0,0)", view);
  run.pass();
  expectParameters(run.lastParameters(), {0.0497296, 0.765856, -0.641086});
}

// recorded: @Ts @Ti @Td
TEST(Tropism, RecordedElasticities) {
  files::ViewSettings view;
  view.movements.push_back(tropism({0, -1, 0}, 0.1));
  TurtleRun run("&(60)F@Ts(1,0.3)F[@Ti(1,0.2)F@Td(1,0.4)F?H(0,0,0)]F@Ti(1)F@Td(1)F?P(0,0,0)", view);
  run.pass();
  expectParameters(run.lastParameters(), {0, -0.679822, -4.50758});
}

TEST(Tropism, ElasticityOfAnUnknownMovementIsReported) {
  TurtleRun run("@Ts(3,0.3)@Ti");
  run.draw();
  ASSERT_EQ(run.messages.size(), 2U);
  EXPECT_EQ(run.messages[0], "the view file has no tropism or torque number 3; it has 0");
  EXPECT_EQ(run.messages[1], "'@Ts', '@Ti' and '@Td' need the number of the tropism or torque: '@Ti(1)'");
}

// recorded: a torque of (0,-1,0), elasticity 0.25
TEST(Tropism, RecordedTorque) {
  files::ViewSettings view;
  view.movements.push_back({.kind = files::Movement::Kind::Torque, .direction = {0, -1, 0}, .elasticity = 0.25});
  TurtleRun run("&(70)/(40)F?L(0,0,0)", view);
  run.pass();
  expectParameters(run.lastParameters(), {-0.660631, -0.705437, -0.256758});
}

// recorded: the old tropism of (0,-1,0), elasticity 0.2
TEST(Tropism, RecordedOldTropism) {
  files::ViewSettings view;
  view.oldTropism = {.isActive = true, .direction = {0, -1, 0}, .initialElasticity = 0.2, .elasticityIncrement = 0.1};
  TurtleRun run("&(60)F?H(0,0,0)F_(0.4)F_F?H(0,0,0)", view);
  run.pass();
  expectParameters(run.parametersOf(3), {0, 0.342443, -0.939539});
  expectParameters(run.lastParameters(), {0, -0.682964, -0.730452});
}

TEST(Tropism, WithoutAnOldTropismTheUnderscoreDoesNothing) {
  TurtleRun run("&(60)_(0.5)F?H(0,0,0)");
  run.pass();
  expectParameters(run.lastParameters(), {0, 0.5, -0.8660254});
}

// recorded: transport without twist between segments, @Tf keeps a turn
TEST(Tropism, RecordedTransportOfTheFrame) {
  files::ViewSettings view;
  view.movements.push_back(tropism({0, -1, 0}, 0.2));
  TurtleRun run("&(50)F+(40)F/(90)F?L(0,0,0)&(30)@Tf F?U(0,0,0)", view);
  run.pass();
  expectParameters(run.parametersOf(7), {-0.68645, -0.303354, 0.66088});
  expectParameters(run.lastParameters(), {0.601421, -0.751123, 0.272225});
}

}  // namespace
}  // namespace espalier::turtle::tropism_test
