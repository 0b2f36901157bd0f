#pragma once

#include <array>
#include <cstdint>

#include "engine/core/elementary.h"
#include "engine/core/frame.h"
#include "engine/core/vec3.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// Width of a line that is given none: `!(0)` sets it.
inline constexpr double kSmallestWidth = 1e-7;

/// How far to turn.
struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
};

/// `elementary`, here and below: the functions of the mode.
[[nodiscard]] Turn turnBy(double radians, core::Elementary elementary = {});

/// The turns that a plant has used: a model has few different angles, and computing cosine and sine costs more than
/// the rest of a turn. Gives the same bits as turnBy.
class TurnCache {
 public:
  explicit TurnCache(core::Elementary elementary = {}) : elementary_(elementary) {}
  [[nodiscard]] const Turn& turnBy(double radians);

 private:
  struct Entry {
    std::uint64_t bits = 0;  // of the angle; the first content is right: 0 radians
    Turn turn;
  };
  core::Elementary elementary_;
  std::array<Entry, 64> entries_;
};

/// The turns of the turtle table, each of two axes of the frame computed from their old values.
void turnLeft(core::Frame& frame, const Turn& turn);   // +  : H toward L
void pitchDown(core::Frame& frame, const Turn& turn);  // &  : H toward U
void rollRight(core::Frame& frame, const Turn& turn);  // /  : L toward U
void turnAround(core::Frame& frame);                   // |  : H and L reversed

// the same by an angle in radians
inline void turnLeft(core::Frame& frame, double radians) {
  turnLeft(frame, turnBy(radians));
}
inline void pitchDown(core::Frame& frame, double radians) {
  pitchDown(frame, turnBy(radians));
}
inline void rollRight(core::Frame& frame, double radians) {
  rollRight(frame, turnBy(radians));
}

/// `v` turned about the unit vector `axis` by the right-hand rule.
[[nodiscard]] core::Vec3 rotatedAbout(const core::Vec3& v, const core::Vec3& axis, double radians,
                                      core::Elementary elementary = {});

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
/// rotation with quaternion curves", appendix), applied as cpfg applies it, although the rows are left-handed.
[[nodiscard]] std::array<double, 4> quaternionOf(const core::Frame& frame);

}  // namespace espalier::turtle
