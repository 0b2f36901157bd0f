#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "environment/light/light_directions.h"

namespace espalier::environment {

/// How bright the sky is over the hemisphere, without the sun itself.
enum class SkyKind : std::uint8_t {
  Uniform,   // the same everywhere
  Overcast,  // CIE standard overcast sky: (1 + 2 cos θ)/3 (Moon & Spencer 1942)
  Clear,     // CIE standard clear sky (Kittler 1967; CIE S 003, 1996)
};

inline constexpr std::array<std::string_view, 3> kSkyNames{"uniform", "overcast", "clear"};

/// Radiance relative to the zenith's, of a point of the sky at the angle θ from the zenith; for Clear also the cosine
/// of its angle γ from the sun and the sun's zenith angle: (0.91 + 10 e^−3γ + 0.45 cos²γ)(1 − e^(−0.32/cos θ)) over the
/// same at the zenith. `cosZenith` is above 0.
[[nodiscard]] double skyRadiance(SkyKind kind, double cosZenith, double cosFromSun, double cosSunZenith);

/// Points and weights on [0, 1] of the Gauss–Legendre rule, exact for polynomials up to degree 2·count − 1.
struct QuadraturePoint {
  double x = 0.0;
  double weight = 0.0;
};
[[nodiscard]] std::vector<QuadraturePoint> gaussLegendre(int count);

/// A hemisphere as rings at the Gauss points of cos θ with equally spaced azimuths, each ring turned by half a space
/// against the one before. `up` is a unit vector, `sun` a unit vector used by Clear. Weights are the parts of the
/// irradiance of a horizontal plane, L(θ) cos θ dω, and sum to 1. O(directions).
[[nodiscard]] std::vector<LightDirection> skyRings(SkyKind kind, int rings, int azimuths, const core::Vec3& up,
                                                   const core::Vec3& sun);

/// Unit vectors across `up` and each other.
[[nodiscard]] std::array<core::Vec3, 2> horizontalAxes(const core::Vec3& up);

}  // namespace espalier::environment
