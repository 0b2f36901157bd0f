#include "engine/turtle/interpretation/tropism.h"

#include <algorithm>
#include <numbers>

#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kSmallestTurn = 1e-6;  // radians
constexpr double kLargestTurn = 1.0;    // radians

Vec3 pullOf(const files::Movement& movement, const Vec3& heading, core::Elementary elementary) {
  if (movement.angleDegrees == 0.0) {
    return movement.direction;
  }
  const double angle = movement.angleDegrees * std::numbers::pi / 180.0;
  const Vec3 normal = core::cross(heading, movement.direction);
  const double l = core::length(normal);
  const Vec3 along = elementary.cos(angle) * movement.direction;
  return l > 0.0 ? along + (elementary.sin(angle) / l) * core::cross(movement.direction, normal) : along;
}

}  // namespace

void applyMovements(TurtleState& state, std::span<const files::Movement> movements, core::Elementary elementary) {
  // sum the pulls of both kinds
  Vec3 pull;
  Vec3 torque;
  bool hasTropism = false;
  bool hasTorque = false;
  const std::size_t count = std::min(movements.size(), kMaximumMovements);
  for (std::size_t i = 0; i < count; ++i) {
    const files::Movement& movement = movements[i];
    if (movement.kind == files::Movement::Kind::Tropism) {
      pull = pull + state.elasticity[i] * pullOf(movement, state.frame.heading, elementary);
      hasTropism = true;
    } else {
      torque = torque + state.elasticity[i] * movement.direction;
      hasTorque = true;
    }
  }
  if (hasTropism) {
    // turn the heading, then carry the up vector along without twist
    const Vec3 axis = core::cross(state.frame.heading, pull);
    const double turn = core::length(axis);
    if (turn >= kSmallestTurn) {
      state.frame.heading = core::normalised(
          rotatedAbout(state.frame.heading, axis * (1.0 / turn), std::min(turn, kLargestTurn), elementary));
    }
    transportUp(state);
  }
  if (hasTorque) {
    // roll the up vector away from the torque's part normal to the heading
    const Vec3& heading = state.frame.heading;
    const Vec3 across = torque - core::dot(torque, heading) * heading;
    const Vec3 axis = core::cross(state.frame.up, across);
    const double turn = core::length(axis);
    if (turn >= kSmallestTurn) {
      state.frame.up = rotatedAbout(state.frame.up, axis * (1.0 / turn), -std::min(turn, kLargestTurn), elementary);
      state.frame.left = core::cross(heading, state.frame.up);
    }
    rememberFrame(state);
  }
}

void applyOldTropism(TurtleState& state, const files::OldTropism& tropism, core::Elementary elementary) {
  const double pitch = std::clamp(state.oldElasticity * core::dot(tropism.direction, state.frame.up), -1.0, 1.0);
  pitchDown(state.frame, turnBy(elementary.asin(pitch), elementary));
  const double turn = std::clamp(state.oldElasticity * core::dot(tropism.direction, state.frame.left), -1.0, 1.0);
  turnLeft(state.frame, turnBy(elementary.asin(turn), elementary));
}

}  // namespace espalier::turtle
