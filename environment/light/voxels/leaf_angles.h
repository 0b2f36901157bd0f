#pragma once

#include <array>
#include <cstdint>
#include <string_view>

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
  Ellipsoidal,   // with the ratio χ of horizontal to vertical axis; χ = 1 is spherical up to 1 %
};

inline constexpr std::array<std::string_view, 9> kLeafAngleNames{"spherical",    "horizontal",  "vertical",
                                                                 "planophile",   "erectophile", "plagiophile",
                                                                 "extremophile", "uniform",     "ellipsoidal"};

/// G(θ), the projection of a unit of leaf area on the plane across a ray that comes from the angle θ to the vertical
/// (Ross 1981). `cosZenith` is |cos θ|, greater than 0 for Ellipsoidal; `ratio` is χ, used by Ellipsoidal only:
/// Campbell's K = √(χ² + tan²θ)/(χ + 1.774 (χ + 1.182)^−0.733) and G = K cos θ. O(1), for de Wit's functions a sum of
/// 2000 terms.
[[nodiscard]] double leafProjection(LeafAngles angles, double cosZenith, double ratio);

}  // namespace espalier::environment
