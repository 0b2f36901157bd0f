#include "environment/light/light_directions.h"

#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

using core::Vec3;

struct SkyTriangle {
  Vec3 a, b, c;
};

/// Of a triangle of unit vectors (Van Oosterom & Strackee, IEEE Transactions on Biomedical Engineering 30, 1983).
double solidAngleOf(const SkyTriangle& t) {
  return 2.0 * core::atan2(std::abs(core::dot(t.a, core::cross(t.b, t.c))),
                           1.0 + core::dot(t.a, t.b) + core::dot(t.b, t.c) + core::dot(t.c, t.a));
}

/// Relative luminance of the CIE overcast sky in the published program's form, with the cosine's factor.
double overcastLuminance(double cosine) {
  return (1.0 + cosine) / 3.0 * (8.6 * cosine + 0.123) / 0.203;
}

}  // namespace

std::vector<LightDirection> sampleSky(const SkyShape& sky, const Vec3& up) {
  // the octahedron
  std::vector<SkyTriangle> triangles;
  for (const double x : {1.0, -1.0}) {
    for (const double y : {1.0, -1.0}) {
      for (const double z : {1.0, -1.0}) {
        triangles.push_back({{x, 0.0, 0.0}, {0.0, y, 0.0}, {0.0, 0.0, z}});
      }
    }
  }
  // each triangle into four
  while (triangles.size() < sky.sampleCount) {
    std::vector<SkyTriangle> finer;
    finer.reserve(4 * triangles.size());
    for (const SkyTriangle& t : triangles) {
      const Vec3 ab = core::normalised(t.a + t.b);
      const Vec3 bc = core::normalised(t.b + t.c);
      const Vec3 ca = core::normalised(t.c + t.a);
      finer.push_back({t.a, ab, ca});
      finer.push_back({ab, t.b, bc});
      finer.push_back({ca, bc, t.c});
      finer.push_back({ab, bc, ca});
    }
    triangles = std::move(finer);
  }
  std::vector<LightDirection> directions;
  directions.reserve(triangles.size());
  for (const SkyTriangle& t : triangles) {
    const Vec3 direction = core::normalised(t.a + t.b + t.c);
    const double cosine = core::dot(direction, up);
    const double brightness = sky.isOvercast ? overcastLuminance(std::abs(cosine)) : 1.0;
    // triangles in the middle of an octant are larger than those at its corners
    directions.push_back({direction, solidAngleOf(t) * brightness * (cosine < 0.0 ? sky.lowerToUpperRatio : 1.0)});
  }
  normaliseLight(directions);
  return directions;
}

void normaliseLight(std::vector<LightDirection>& directions) {
  double sum = 0.0;
  for (LightDirection& light : directions) {
    light.direction = core::normalised(light.direction);
    sum += light.weight;
  }
  if (sum != 0.0) {
    for (LightDirection& light : directions) {
      light.weight /= sum;
    }
  }
}

}  // namespace espalier::environment
