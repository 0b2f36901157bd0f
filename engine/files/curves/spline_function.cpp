#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/check.h"
#include "engine/files/curves/b_spline.h"
#include "engine/files/view_settings.h"

namespace espalier::files {
namespace {

constexpr double kTolerance = 0.001;
// after so many halvings of [0, 1] the bounds are neighbouring doubles
constexpr int kMostHalvings = 60;

}  // namespace

SplineFunction::SplineFunction(std::string name, std::vector<std::array<double, 2>> points, int sampleCount)
    : name_(std::move(name)), points_(std::move(points)) {
  ESPALIER_CHECK(points_.size() >= 4);
  if (sampleCount <= 2) {
    return;
  }
  table_.reserve(static_cast<std::size_t>(sampleCount));
  for (int i = 0; i < sampleCount; ++i) {
    table_.push_back(exactValue(static_cast<double>(i) / (sampleCount - 1)));
  }
}

double SplineFunction::value(double x) const {
  // written so that NaN becomes 0
  const double clamped = x > 0.0 ? std::min(x, 1.0) : 0.0;
  if (table_.empty()) {
    return exactValue(clamped);
  }
  const double place = clamped * static_cast<double>(table_.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(place), table_.size() - 2);
  const double share = place - static_cast<double>(i);
  return table_[i] * (1.0 - share) + table_[i + 1] * share;
}

std::array<double, 2> SplineFunction::point(double parameter) const {
  const BSplineWeights spline = clampedBSplineWeights(points_.size(), parameter);
  std::array<double, 2> result{};
  for (std::size_t i = 0; i < 4; ++i) {
    result[0] += spline.weights[i] * points_[spline.first + i][0];
    result[1] += spline.weights[i] * points_[spline.first + i][1];
  }
  return result;
}

double SplineFunction::exactValue(double x) const {
  double low = 0.0;
  double high = 1.0;
  double middle = 0.5;
  std::array<double, 2> at = point(middle);
  for (int i = 0; i < kMostHalvings && !(std::fabs(at[0] - x) <= kTolerance); ++i) {
    (at[0] < x ? low : high) = middle;
    middle = 0.5 * (low + high);
    at = point(middle);
  }
  return at[1];
}

}  // namespace espalier::files
