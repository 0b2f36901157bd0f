#pragma once

#include <array>
#include <cstddef>

namespace espalier::files {

/// The four control points that a cubic B-spline mixes at one parameter, and their weights (sum 1).
struct BSplineWeights {
  std::size_t first = 0;  // the control points first .. first + 3
  std::array<double, 4> weights{};
};

/// Uniform cubic B-spline without end conditions: segment `segment` at `u` in [0, 1].
[[nodiscard]] BSplineWeights uniformBSplineWeights(std::size_t segment, double u);

/// Open uniform cubic B-spline (end knots fourfold, so that it starts in the first control point and ends in the last)
/// of pointCount >= 4 points, at parameter p, clamped to [0, 1]. De Boor 1978, algorithm of the non-zero basis
/// functions.
[[nodiscard]] BSplineWeights clampedBSplineWeights(std::size_t pointCount, double p);

}  // namespace espalier::files
