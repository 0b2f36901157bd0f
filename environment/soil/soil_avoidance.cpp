#include "environment/soil/soil_avoidance.h"

#include <algorithm>
#include <array>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr double kDegree = std::numbers::pi / 180.0;

struct Turn {
  double degrees = 0.0;
  Vec3 direction;
};

/// The least turn of a unit vector that leads past the obstacles; 180 degrees when there is none.
Turn leastTurn(const SoilField& field, const Vec3& from, double length, const Vec3& unit, const Vec3& left) {
  const auto isFree = [&](const Vec3& d) { return !field.isBlocked(from, from + d * length); };
  if (isFree(unit)) {
    return {0.0, unit};
  }
  const bool isInSpace = field.isInSpace();
  const Vec3 side = isInSpace ? core::normalised(core::cross(unit, left)) : Vec3{0.0, 0.0, 1.0};
  constexpr int kPlanes = 8;
  for (int k = 1; k < 90; ++k) {
    for (int plane = 0; plane < (isInSpace ? kPlanes : 1); ++plane) {
      const Vec3 axis = isInSpace ? rotated(side, unit, std::numbers::pi * plane / kPlanes) : side;
      for (const double degrees : {2.0 * k, -2.0 * k}) {
        const Vec3 turned = rotated(unit, axis, degrees * kDegree);
        if (isFree(turned)) {
          return {degrees, turned};
        }
      }
    }
  }
  return {180.0, -unit};
}

}  // namespace

Vec3 rotated(const Vec3& v, const Vec3& axis, double radians) {
  const double c = core::cos(radians);
  const double s = core::sin(radians);
  return v * c + core::cross(axis, v) * s + axis * (core::dot(axis, v) * (1.0 - c));
}

void answerAvoidance(const SoilField& field, const turtle::QueryBatch& queries, std::size_t query,
                     turtle::ReplyBatch& replies) {
  const auto parameters = queries.parametersOf(query);
  if (parameters.size() < 5) {
    return;
  }
  const bool isInSpace = field.isInSpace();
  const Vec3 left = isInSpace ? queries.left[query] : Vec3{};
  const double divergence = parameters.size() > 5 ? parameters[5] : 0.0;
  const Vec3 normal = isInSpace ? core::normalised(left) : Vec3{0.0, 0.0, 1.0};
  const Vec3 direction = rotated(queries.heading[query], normal, divergence * kDegree);
  const Turn turn = leastTurn(field, queries.position[query], parameters[4], core::normalised(direction), left);
  if (!isInSpace) {
    replies.set(queries, query, 4, turn.degrees);
    return;
  }
  const std::array<double, 3> components{turn.direction.x, turn.direction.y, turn.direction.z};
  for (std::size_t k = 4; k < std::min<std::size_t>(parameters.size(), 7); ++k) {
    replies.set(queries, query, k, components[k - 4]);
  }
}

}  // namespace espalier::environment
