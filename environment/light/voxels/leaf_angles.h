#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace espalier::environment {

/// How the leaf normals of a canopy are distributed over the angle α from the vertical, evenly around it: the functions
/// of de Wit (1965), leaves all horizontal or all vertical, and the ellipsoid of Campbell (1986).
enum class LeafAngles : std::uint8_t {
  Spherical,     // g = sin α
  Horizontal,    // all α = 0
  Vertical,      // all α = 90°
  Planophile,    // g = 2/π (1 + cos 2α)
  Erectophile,   // g = 2/π (1 − cos 2α)
  Plagiophile,   // g = 2/π (1 − cos 4α)
  Extremophile,  // g = 2/π (1 + cos 4α)
  Uniform,       // g = 2/π
  Ellipsoidal,   // with the ratio χ of horizontal to vertical axis; χ = 1 is spherical
};

inline constexpr std::array<std::string_view, 9> kLeafAngleNames{"spherical",    "horizontal",  "vertical",
                                                                 "planophile",   "erectophile", "plagiophile",
                                                                 "extremophile", "uniform",     "ellipsoidal"};

/// The distribution with one of these names.
[[nodiscard]] LeafAngles leafAnglesOf(std::string_view name);

/// G(θ), the projection of a unit of leaf area on the plane across a ray that comes from the angle θ to the vertical
/// (Ross 1981). `cosZenith` is |cos θ|, greater than 0 for Ellipsoidal; `ratio` is χ, used by Ellipsoidal only:
/// Campbell's K = √(χ² + tan²θ)/Λ and G = K cos θ, with the exact Λ, the half surface of the ellipsoid over that of its
/// vertical section: χ + arcsin(ε)/ε for χ < 1, χ + ln((1 + ε)/(1 − ε))/(2εχ) for χ > 1, ε² = 1 − χ^±2. O(1), for de
/// Wit's functions a sum of 2000 terms.
[[nodiscard]] double leafProjection(LeafAngles angles, double cosZenith, double ratio);

/// A ring of leaf normals: the cosine of their angle to the vertical, and their part of the leaf area.
struct LeafNormals {
  double cosine = 1.0;
  double part = 0.0;
};

/// The distribution of leaf normals as rings by the Gauss–Legendre rule; parts add up to 1. Of the ellipsoid the area
/// by normals is that of its surface, sin α/(cos²α + χ² sin²α)².
[[nodiscard]] std::vector<LeafNormals> leafNormals(LeafAngles angles, double ratio);

}  // namespace espalier::environment
