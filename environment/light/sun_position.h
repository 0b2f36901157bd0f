#pragma once

#include <optional>
#include <string_view>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// Where the sun stands.
struct SunPosition {
  double elevationRadians = 0.0;  // above the horizon, without refraction
  double azimuthRadians = 0.0;    // from north over east
};

/// The Julian day of a moment of universal time: "2026-06-21", "2026-06-21T12:00", "...:30", with "Z" or nothing
/// behind. Nothing when the text is no such date. Proleptic Gregorian calendar, years 1 to 9999.
[[nodiscard]] std::optional<double> julianDayOf(std::string_view text);

/// The sun seen from a place: longitude and anomalies after Meeus, *Astronomical Algorithms* (1998), chapter 25
/// (0.01°), with mean sidereal time and the sun's parallax. `longitudeDegrees` is positive to the east. O(1).
[[nodiscard]] SunPosition sunPosition(double julianDay, double latitudeDegrees, double longitudeDegrees);

/// The unit vector towards the sun in a world whose up and north are unit vectors at right angles.
[[nodiscard]] core::Vec3 sunDirection(const SunPosition& sun, const core::Vec3& up, const core::Vec3& north);

/// Irradiance above the air on a plane that faces the sun, W/m²: 1361 times the square of the mean distance over the
/// present one.
[[nodiscard]] double solarIrradiance(double julianDay);

}  // namespace espalier::environment
