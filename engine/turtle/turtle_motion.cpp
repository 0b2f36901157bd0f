#include "engine/turtle/turtle_motion.h"

#include <bit>
#include <cmath>

namespace espalier::turtle {

using core::Frame;
using core::Vec3;

namespace {

// turns a toward b in their plane: a' = c a + s b, b' = c b - s a
void turnToward(Vec3& a, Vec3& b, const Turn& turn) {
  const double c = turn.cosine;
  const double s = turn.sine;
  const Vec3 oldA = a;
  const Vec3 oldB = b;
  a = c * oldA + s * oldB;
  b = c * oldB - s * oldA;
}

Vec3 headingOrDefault(const Vec3& heading) {
  return core::length(heading) > 0.0 ? core::normalised(heading) : Vec3{0.0, 1.0, 0.0};
}

}  // namespace

Turn turnBy(double radians, core::Elementary elementary) {
  return {elementary.cos(radians), elementary.sin(radians)};
}

const Turn& TurnCache::turnBy(double radians) {
  const auto bits = std::bit_cast<std::uint64_t>(radians);
  // the upper six bits of a multiplicative hash choose the place
  Entry& entry = entries_[(bits * 0x9E3779B97F4A7C15U) >> 58U];
  if (entry.bits != bits) {
    entry = {bits, turtle::turnBy(radians, elementary_)};
  }
  return entry.turn;
}

void turnLeft(Frame& frame, const Turn& turn) {
  turnToward(frame.heading, frame.left, turn);
}

void pitchDown(Frame& frame, const Turn& turn) {
  turnToward(frame.heading, frame.up, turn);
}

void rollRight(Frame& frame, const Turn& turn) {
  turnToward(frame.left, frame.up, turn);
}

void turnAround(Frame& frame) {
  frame.heading = -frame.heading;
  frame.left = -frame.left;
}

Vec3 rotatedAbout(const Vec3& v, const Vec3& axis, double radians, core::Elementary elementary) {
  const double c = elementary.cos(radians);
  const double s = elementary.sin(radians);
  return c * v + s * core::cross(axis, v) + ((1.0 - c) * core::dot(axis, v)) * axis;
}

Vec3 transported(const Vec3& up, const Vec3& from, const Vec3& to) {
  const Vec3 axis = core::cross(from, to);
  const double s = core::length(axis);
  const double c = core::dot(from, to);
  if (s < 1e-12) {
    return up;
  }
  // Rodrigues' formula with the unit axis k: up c + (k x up) s + k (k . up)(1 - c)
  const Vec3 k = axis * (1.0 / s);
  return c * up + s * core::cross(k, up) + ((1.0 - c) * core::dot(k, up)) * k;
}

void transportUp(TurtleState& state) {
  state.frame.up = transported(state.previousUp, state.previousHeading, state.frame.heading);
  state.frame.left = core::cross(state.frame.heading, state.frame.up);
}

void setHeading(TurtleState& state, const Vec3& heading) {
  state.frame.heading = headingOrDefault(heading);
  transportUp(state);
}

void setHeading(TurtleState& state, const Vec3& heading, const Vec3& up) {
  const Vec3 h = headingOrDefault(heading);
  if (core::length(up) == 0.0 || core::dot(heading, up) != 0.0 || core::length(heading) == 0.0) {
    setHeading(state, heading);
    return;
  }
  state.frame.heading = h;
  state.frame.up = core::normalised(up);
  state.frame.left = core::cross(h, state.frame.up);
}

void rollToVertical(Frame& frame) {
  const Vec3 left = core::cross(Vec3{0.0, 1.0, 0.0}, frame.heading);
  const double l = core::length(left);
  if (l < 1e-9) {
    return;
  }
  frame.left = left * (1.0 / l);
  frame.up = core::cross(frame.left, frame.heading);
}

std::array<double, 4> quaternionOf(const Frame& frame) {
  const Vec3& h = frame.heading;
  const Vec3& l = frame.left;
  const Vec3& u = frame.up;
  constexpr double kSmallest = 1e-9;
  const double w2 = 0.25 * (1.0 + h.x + l.y + u.z);
  if (w2 > kSmallest) {
    const double w = std::sqrt(w2);
    return {(l.z - u.y) / (4.0 * w), (u.x - h.z) / (4.0 * w), (h.y - l.x) / (4.0 * w), w};
  }
  const double x2 = -0.5 * (l.y + u.z);
  if (x2 > kSmallest) {
    const double x = std::sqrt(x2);
    return {x, h.y / (2.0 * x), h.z / (2.0 * x), 0.0};
  }
  const double y2 = 0.5 * (1.0 - u.z);
  if (y2 > kSmallest) {
    const double y = std::sqrt(y2);
    return {0.0, y, l.z / (2.0 * y), 0.0};
  }
  return {0.0, 0.0, 1.0, 0.0};
}

}  // namespace espalier::turtle
