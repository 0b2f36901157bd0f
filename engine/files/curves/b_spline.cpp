#include "engine/files/curves/b_spline.h"

#include <algorithm>

#include "engine/core/check.h"

namespace espalier::files {

BSplineWeights uniformBSplineWeights(std::size_t segment, double u) {
  const double v = 1.0 - u;
  BSplineWeights result;
  result.first = segment;
  result.weights = {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
                    (-3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0) / 6.0, u * u * u / 6.0};
  return result;
}

BSplineWeights clampedBSplineWeights(std::size_t pointCount, double p) {
  ESPALIER_CHECK(pointCount >= 4);
  const std::size_t spans = pointCount - 3;
  const double t = std::clamp(p, 0.0, 1.0) * static_cast<double>(spans);
  const std::size_t span = std::min(static_cast<std::size_t>(t), spans - 1);
  // knot i, counted from the knot at the beginning of the span; the inner knots are the integers 0 .. spans
  const auto knot = [&](int i) { return std::clamp(static_cast<double>(span) + i, 0.0, static_cast<double>(spans)); };
  BSplineWeights result;
  result.first = span;
  std::array<double, 4>& basis = result.weights;
  basis[0] = 1.0;
  for (int degree = 1; degree <= 3; ++degree) {
    double saved = 0.0;
    for (int j = 0; j < degree; ++j) {
      const double right = knot(j + 1);
      const double left = knot(j + 1 - degree);
      const double share = basis[static_cast<std::size_t>(j)] / (right - left);
      basis[static_cast<std::size_t>(j)] = saved + (right - t) * share;
      saved = (t - left) * share;
    }
    basis[static_cast<std::size_t>(degree)] = saved;
  }
  return result;
}

}  // namespace espalier::files
