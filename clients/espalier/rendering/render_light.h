#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "engine/core/vec3.h"

namespace espalier::command {

/// Light by its parts: red, green and blue, linear.
using Light = std::array<double, 3>;

/// The sun and a clear sky above a level ground (`environment/light/sky.h`). A white ground that nothing shades is seen
/// as 1 in each part.
class Daylight {
 public:
  /// `towardSun` is a unit vector. Below 5 degrees it is raised to that height: a picture needs light.
  explicit Daylight(core::Vec3 towardSun);

  /// A direction to a point of the sun's disc, which is drawn three times as large as the sky's, for soft shadows.
  /// `u`, `v`: 0 to 1.
  [[nodiscard]] core::Vec3 towardSun(double u, double v) const;
  /// The light of the sun on a surface that faces it.
  [[nodiscard]] const Light& sun() const { return sun_; }
  /// The light of the sky in a direction, without the sun. From below the horizon: the light of a bright ground.
  [[nodiscard]] Light sky(const core::Vec3& direction) const;
  /// The light of sun and sky on a level ground by its parts: sun, sky. The parts of both sum to 1.
  [[nodiscard]] const Light& sunOnGround() const { return sunOnGround_; }

 private:
  core::Vec3 sunDirection_;
  std::array<core::Vec3, 2> across_;
  Light sun_{};
  Light sunOnGround_{};
  Light skyTint_{};
  double zenithRadiance_ = 1.0;
};

}  // namespace espalier::command
