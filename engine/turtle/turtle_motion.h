#pragma once

#include <array>

#include "engine/core/frame.h"
#include "engine/core/vec3.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// The turns of the turtle table, each of two axes of the frame computed from their old values. Radians.
void turnLeft(core::Frame& frame, double radians);   // +  : H toward L
void pitchDown(core::Frame& frame, double radians);  // &  : H toward U
void rollRight(core::Frame& frame, double radians);  // /  : L toward U
void turnAround(core::Frame& frame);                 // |  : H and L reversed

/// `v` turned about the unit vector `axis` by the right-hand rule.
[[nodiscard]] core::Vec3 rotatedAbout(const core::Vec3& v, const core::Vec3& axis, double radians);

/// `up` carried along when the heading turns from `from` to `to` by the shortest way: no twist. Opposite headings keep
/// it.
[[nodiscard]] core::Vec3 transported(const core::Vec3& up, const core::Vec3& from, const core::Vec3& to);

/// Sets U to the previous drawn segment's, carried to the present heading, and L accordingly (@Tp).
void transportUp(TurtleState& state);

/// Remembers H and U as those of the last drawn segment.
inline void rememberFrame(TurtleState& state) {
  state.previousHeading = state.frame.heading;
  state.previousUp = state.frame.up;
}

/// @R without an up vector: the heading (normalised; a zero vector gives +y), U transported from the last drawn
/// segment.
void setHeading(TurtleState& state, const core::Vec3& heading);
/// @R with an up vector, which counts only when it is exactly perpendicular to the heading as given.
void setHeading(TurtleState& state, const core::Vec3& heading, const core::Vec3& up);

/// @v: L becomes horizontal, L = Y x H, U = L x H. Nothing for a vertical heading.
void rollToVertical(core::Frame& frame);

/// ?Q: the unit quaternion (x, y, z, w) of the matrix with rows H, L, U by the algorithm of Shoemake 1985 ("Animating
/// rotation with quaternion curves", appendix), applied as the field's tools do although the rows are left-handed.
[[nodiscard]] std::array<double, 4> quaternionOf(const core::Frame& frame);

}  // namespace espalier::turtle
