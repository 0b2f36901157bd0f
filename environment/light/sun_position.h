#pragma once

#include "engine/core/vec3.h"
#include "engine/turtle/world.h"

namespace espalier::environment {

using turtle::julianDayOf;

/// Where the sun stands.
struct SunPosition {
  double elevationRadians = 0.0;  // above the horizon, without refraction
  double azimuthRadians = 0.0;    // from north over east
};

/// The sun seen from a place: longitude and anomalies after Meeus, *Astronomical Algorithms* (1998), chapter 25
/// (0.01°), with mean sidereal time and the sun's parallax. `longitudeDegrees` is positive to the east. O(1).
[[nodiscard]] SunPosition sunPosition(double julianDay, double latitudeDegrees, double longitudeDegrees);

/// The unit vector towards the sun in a world whose up and north are unit vectors at right angles.
[[nodiscard]] core::Vec3 sunDirection(const SunPosition& sun, const core::Vec3& up, const core::Vec3& north);

/// Irradiance above the air on a plane that faces the sun, W/m²: 1361 times the square of the mean distance over the
/// present one.
[[nodiscard]] double solarIrradiance(double julianDay);

}  // namespace espalier::environment
