#include "environment/light/voxels/leaf_angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "environment/light/sky.h"

namespace espalier::environment {

namespace {

using std::numbers::pi;

/// Density of leaf area over α.
double leafAngleDensity(LeafAngles angles, double alpha) {
  switch (angles) {
    case LeafAngles::Planophile:
      return 2.0 / pi * (1.0 + core::cos(2.0 * alpha));
    case LeafAngles::Erectophile:
      return 2.0 / pi * (1.0 - core::cos(2.0 * alpha));
    case LeafAngles::Plagiophile:
      return 2.0 / pi * (1.0 - core::cos(4.0 * alpha));
    case LeafAngles::Extremophile:
      return 2.0 / pi * (1.0 + core::cos(4.0 * alpha));
    case LeafAngles::Spherical:
      return core::sin(alpha);
    default:
      return 2.0 / pi;
  }
}

/// Mean of |cos| of the angle between ray and normal over all azimuths of the normal (Warren Wilson 1960).
double meanProjection(double cosZenith, double alpha) {
  const double sinZenith = std::sqrt(std::max(0.0, 1.0 - cosZenith * cosZenith));
  const double across = core::sin(alpha) * sinZenith;
  const double along = core::cos(alpha) * cosZenith;
  if (along >= across) {
    return along;
  }
  const double psi = core::acos(along / across);
  return along + 2.0 / pi * (std::sqrt(across * across - along * along) - along * psi);
}

/// Λ of leafProjection().
double halfSurface(double ratio) {
  const double flat = ratio < 1.0 ? 1.0 - ratio * ratio : 1.0 - 1.0 / (ratio * ratio);
  if (flat < 1e-9) {
    return 2.0;
  }
  const double epsilon = std::sqrt(flat);
  return ratio < 1.0 ? ratio + core::asin(epsilon) / epsilon
                     : ratio + core::log((1.0 + epsilon) / (1.0 - epsilon)) / (2.0 * epsilon * ratio);
}

}  // namespace

LeafAngles leafAnglesOf(std::string_view name) {
  return static_cast<LeafAngles>(std::find(kLeafAngleNames.begin(), kLeafAngleNames.end(), name) -
                                 kLeafAngleNames.begin());
}

double leafProjection(LeafAngles angles, double cosZenith, double ratio) {
  switch (angles) {
    case LeafAngles::Spherical:
      return 0.5;
    case LeafAngles::Horizontal:
      return cosZenith;
    case LeafAngles::Vertical:
      return 2.0 / pi * std::sqrt(std::max(0.0, 1.0 - cosZenith * cosZenith));
    case LeafAngles::Ellipsoidal: {
      const double tangent = std::sqrt(std::max(0.0, 1.0 - cosZenith * cosZenith)) / cosZenith;
      return std::sqrt(ratio * ratio + tangent * tangent) / halfSurface(ratio) * cosZenith;
    }
    default:
      break;
  }
  // midpoint rule
  constexpr int kTerms = 2000;
  const double width = pi / 2.0 / kTerms;
  double sum = 0.0;
  for (int i = 0; i < kTerms; ++i) {
    const double alpha = (i + 0.5) * width;
    sum += leafAngleDensity(angles, alpha) * meanProjection(cosZenith, alpha) * width;
  }
  return sum;
}

std::vector<LeafNormals> leafNormals(LeafAngles angles, double ratio) {
  if (angles == LeafAngles::Horizontal) {
    return {{1.0, 1.0}};
  }
  if (angles == LeafAngles::Vertical) {
    return {{0.0, 1.0}};
  }
  constexpr int kRings = 6;
  std::vector<LeafNormals> rings;
  double sum = 0.0;
  for (const auto& [x, width] : gaussLegendre(kRings)) {
    const double alpha = x * pi / 2.0;
    const double sine = core::sin(alpha);
    const double cosine = core::cos(alpha);
    const double axes = cosine * cosine + ratio * ratio * sine * sine;
    const double density = angles == LeafAngles::Ellipsoidal ? sine / (axes * axes) : leafAngleDensity(angles, alpha);
    rings.push_back({cosine, density * width});
    sum += density * width;
  }
  for (LeafNormals& ring : rings) {
    ring.part /= sum;
  }
  return rings;
}

}  // namespace espalier::environment
