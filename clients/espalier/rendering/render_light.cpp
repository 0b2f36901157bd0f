#include "clients/espalier/rendering/render_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "environment/light/sky.h"

namespace espalier::command {

using core::Vec3;

namespace {

constexpr double kSkyShare = 0.34;  // of the light on a level ground
constexpr Light kSkyColour{0.86, 0.97, 1.22};
constexpr double kSunRadius = 0.0140;  // radians; the sky's is 0.0047
constexpr double kLowestSun = 0.0872;  // sine of 5 degrees
constexpr double kGroundLight = 0.32;  // the light that the ground throws back, seen from above

}  // namespace

Daylight::Daylight(Vec3 towardSun) {
  if (towardSun.y < kLowestSun) {
    const double level = std::sqrt(towardSun.x * towardSun.x + towardSun.z * towardSun.z);
    const double factor = level > 0.0 ? std::sqrt(1.0 - kLowestSun * kLowestSun) / level : 0.0;
    towardSun = core::normalised(Vec3{towardSun.x * factor, level > 0.0 ? kLowestSun : 1.0, towardSun.z * factor});
  }
  sunDirection_ = towardSun;
  across_ = environment::horizontalAxes(sunDirection_);

  // the light of the whole sky on level ground, of a sky with the radiance 1 at the zenith
  constexpr int kRings = 32;
  constexpr int kAzimuths = 64;
  double onGround = 0.0;
  for (const environment::QuadraturePoint& ring : environment::gaussLegendre(kRings)) {
    const double level = std::sqrt(1.0 - ring.x * ring.x);
    for (int k = 0; k < kAzimuths; ++k) {
      const double azimuth = 2.0 * std::numbers::pi * (k + 0.5) / kAzimuths;
      const Vec3 way{level * core::cos(azimuth), ring.x, level * core::sin(azimuth)};
      onGround +=
          ring.weight * ring.x * 2.0 * std::numbers::pi / kAzimuths *
          environment::skyRadiance(environment::SkyKind::Clear, ring.x, core::dot(way, sunDirection_), sunDirection_.y);
    }
  }
  // a ground of the albedo 1 is seen as its irradiance over pi
  zenithRadiance_ = kSkyShare * std::numbers::pi / onGround;
  for (std::size_t k = 0; k < 3; ++k) {
    skyTint_[k] = kSkyColour[k];
    sunOnGround_[k] = 1.0 - kSkyShare * kSkyColour[k];
    sun_[k] = sunOnGround_[k] / sunDirection_.y;
  }
}

Vec3 Daylight::towardSun(double u, double v) const {
  const double radius = kSunRadius * std::sqrt(u);
  const double turn = 2.0 * std::numbers::pi * v;
  return core::normalised(sunDirection_ + radius * core::cos(turn) * across_[0] +
                          radius * core::sin(turn) * across_[1]);
}

Light Daylight::sky(const Vec3& direction) const {
  if (direction.y <= 1e-4) {
    return {kGroundLight, kGroundLight, kGroundLight};
  }
  const double radiance =
      zenithRadiance_ * environment::skyRadiance(environment::SkyKind::Clear, direction.y,
                                                 core::dot(direction, sunDirection_), sunDirection_.y);
  return {radiance * skyTint_[0], radiance * skyTint_[1], radiance * skyTint_[2]};
}

}  // namespace espalier::command
