#include "environment/light/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

double skyRadiance(SkyKind kind, double cosZenith, double cosFromSun, double cosSunZenith) {
  switch (kind) {
    case SkyKind::Uniform:
      return 1.0;
    case SkyKind::Overcast:
      return (1.0 + 2.0 * cosZenith) / 3.0;
    case SkyKind::Clear:
      break;
  }
  const auto scattered = [](double cosine) {
    const double bounded = std::clamp(cosine, -1.0, 1.0);
    return 0.91 + 10.0 * core::exp(-3.0 * core::acos(bounded)) + 0.45 * bounded * bounded;
  };
  return scattered(cosFromSun) * -core::expm1(-0.32 / cosZenith) / (scattered(cosSunZenith) * -core::expm1(-0.32));
}

std::vector<QuadraturePoint> gaussLegendre(int count) {
  std::vector<QuadraturePoint> points;
  for (int i = 0; i < count; ++i) {
    // Newton's method on the Legendre polynomial of degree `count`
    double x = core::cos(pi * (i + 0.75) / (count + 0.5));
    double slope = 1.0;
    for (int round = 0; round < 100; ++round) {
      double before = 1.0;
      double value = x;
      for (int degree = 2; degree <= count; ++degree) {
        const double next = ((2.0 * degree - 1.0) * x * value - (degree - 1.0) * before) / degree;
        before = value;
        value = next;
      }
      slope = count * (x * value - before) / (x * x - 1.0);
      const double change = value / slope;
      x -= change;
      if (std::abs(change) < 1e-15) {
        break;
      }
    }
    points.push_back({(x + 1.0) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope)});
  }
  return points;
}

std::array<Vec3, 2> horizontalAxes(const Vec3& up) {
  // the world axis that is furthest from up
  const Vec3 start = std::abs(up.x) <= std::abs(up.y) && std::abs(up.x) <= std::abs(up.z) ? Vec3{1, 0, 0}
                     : std::abs(up.y) <= std::abs(up.z)                                   ? Vec3{0, 1, 0}
                                                                                          : Vec3{0, 0, 1};
  const Vec3 first = core::normalised(start - up * core::dot(up, start));
  return {first, core::cross(up, first)};
}

std::vector<LightDirection> skyRings(SkyKind kind, int rings, int azimuths, const Vec3& up, const Vec3& sun) {
  const auto [first, second] = horizontalAxes(up);
  std::vector<LightDirection> directions;
  int ring = 0;
  for (const auto& [cosine, width] : gaussLegendre(rings)) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    for (int k = 0; k < azimuths; ++k) {
      const double azimuth = 2.0 * pi * (k + (ring % 2 == 0 ? 0.25 : 0.75)) / azimuths;
      const Vec3 direction = up * cosine + first * (sine * core::cos(azimuth)) + second * (sine * core::sin(azimuth));
      const double radiance = skyRadiance(kind, cosine, core::dot(direction, sun), core::dot(up, sun));
      directions.push_back({direction, radiance * cosine * width});
    }
    ++ring;
  }
  normaliseLight(directions);
  return directions;
}

}  // namespace espalier::environment
