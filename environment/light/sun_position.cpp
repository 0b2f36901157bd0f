#include "environment/light/sun_position.h"

#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

using core::Vec3;
constexpr double kDegree = std::numbers::pi / 180.0;

/// Centuries since 2000, the sun's true longitude and anomaly in radians, and the eccentricity of the orbit.
struct Orbit {
  double centuries, longitude, anomaly, eccentricity;
};

Orbit orbitAt(double day) {
  const double t = (day - 2451545.0) / 36525.0;
  const double mean = (280.46646 + t * (36000.76983 + t * 0.0003032)) * kDegree;
  const double anomaly = (357.52911 + t * (35999.05029 - t * 0.0001537)) * kDegree;
  const double centre = ((1.914602 - t * (0.004817 + t * 0.000014)) * core::sin(anomaly) +
                         (0.019993 - t * 0.000101) * core::sin(2.0 * anomaly) + 0.000289 * core::sin(3.0 * anomaly)) *
                        kDegree;
  return {t, mean + centre, anomaly + centre, 0.016708634 - t * (0.000042037 + t * 0.0000001267)};
}

/// Of the sun, in astronomical units.
double distanceOf(const Orbit& orbit) {
  return 1.000001018 * (1.0 - orbit.eccentricity * orbit.eccentricity) /
         (1.0 + orbit.eccentricity * core::cos(orbit.anomaly));
}

}  // namespace

SunPosition sunPosition(double day, double latitudeDegrees, double longitudeDegrees) {
  const Orbit orbit = orbitAt(day);
  const double node = (125.04 - 1934.136 * orbit.centuries) * kDegree;
  // aberration and nutation, then from the ecliptic to the equator
  const double longitude = orbit.longitude - (0.00569 + 0.00478 * core::sin(node)) * kDegree;
  const double obliquity = (23.43929111 - orbit.centuries * 0.0130041667 + 0.00256 * core::cos(node)) * kDegree;
  const double ascension = core::atan2(core::cos(obliquity) * core::sin(longitude), core::cos(longitude));
  const double declination = core::asin(core::sin(obliquity) * core::sin(longitude));
  const double t = orbit.centuries;
  const double sidereal =
      (280.46061837 + 360.98564736629 * (day - 2451545.0) + t * t * (0.000387933 - t / 38710000.0)) * kDegree;
  const double hourAngle = sidereal + longitudeDegrees * kDegree - ascension;
  const double latitude = latitudeDegrees * kDegree;
  const double sine = core::sin(latitude) * core::sin(declination) +
                      core::cos(latitude) * core::cos(declination) * core::cos(hourAngle);
  const double elevation = core::asin(sine);
  const double azimuth = core::atan2(-core::sin(hourAngle) * core::cos(declination),
                                     core::cos(latitude) * core::sin(declination) -
                                         core::sin(latitude) * core::cos(declination) * core::cos(hourAngle));
  // seen from the surface the sun stands 8.794" lower at the horizon
  const double parallax = 8.794 / 3600.0 * kDegree * core::cos(elevation);
  return {elevation - parallax, azimuth < 0.0 ? azimuth + 2.0 * std::numbers::pi : azimuth};
}

Vec3 sunDirection(const SunPosition& sun, const Vec3& up, const Vec3& north) {
  const Vec3 east = core::cross(north, up);
  return up * core::sin(sun.elevationRadians) +
         (north * core::cos(sun.azimuthRadians) + east * core::sin(sun.azimuthRadians)) *
             core::cos(sun.elevationRadians);
}

double solarIrradiance(double day) {
  const double distance = distanceOf(orbitAt(day));
  return 1361.0 / (distance * distance);
}

}  // namespace espalier::environment
