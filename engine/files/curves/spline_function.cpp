#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "engine/core/check.h"
#include "engine/files/curves/b_spline.h"
#include "engine/files/view_settings.h"

namespace espalier::files {
namespace {

constexpr double kTolerance = 0.001;
// after so many halvings of [0, 1] the bounds are neighbouring doubles
constexpr int kMostHalvings = 60;
// in place of the number of the next halving: this was the last; it is not known, because rounding leads there alone
constexpr std::uint32_t kLast = 0;
constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();

}  // namespace

SplineFunction::SplineFunction(std::string name, std::vector<std::array<double, 2>> points, int sampleCount)
    : name_(std::move(name)), points_(std::move(points)) {
  ESPALIER_CHECK(points_.size() >= 4);
  if (sampleCount <= 2) {
    prepareHalvings();
    return;
  }
  table_.reserve(static_cast<std::size_t>(sampleCount));
  for (int i = 0; i < sampleCount; ++i) {
    table_.push_back(bisect(static_cast<double>(i) / (sampleCount - 1)));
  }
}

double SplineFunction::value(double x) const {
  // written so that NaN becomes 0
  const double clamped = x > 0.0 ? std::min(x, 1.0) : 0.0;
  if (table_.empty()) {
    const Halving* at = halvings_.data();
    while (!(std::fabs(at->x - clamped) <= kTolerance)) {
      const std::uint32_t next = at->next[at->x < clamped ? 1 : 0];
      if (next == kLast) {
        break;
      }
      if (next == kUnknown) {
        return bisect(clamped);
      }
      at = halvings_.data() + next;
    }
    return at->y;
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

double SplineFunction::bisect(double x) const {
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

void SplineFunction::prepareHalvings() {
  struct Part {
    std::uint32_t above;  // the point before, and which of its next this is
    std::size_t side;
    double low, high;          // of the parameter
    double smallest, largest;  // x for which the bisection comes here
    int depth;
  };
  std::vector<Part> parts{{0, 0, 0.0, 1.0, 0.0, 1.0, 0}};
  while (!parts.empty()) {
    const Part part = parts.back();
    parts.pop_back();
    const double middle = 0.5 * (part.low + part.high);
    const std::array<double, 2> at = point(middle);
    const auto number = static_cast<std::uint32_t>(halvings_.size());
    if (number > 0) {
      halvings_[part.above].next[part.side] = number;
    }
    const std::uint32_t next = part.depth == kMostHalvings ? kLast : kUnknown;
    halvings_.push_back({at[0], at[1], {next, next}});
    if (next == kLast) {
      continue;
    }
    const double largest = std::min(part.largest, at[0] - kTolerance);
    if (part.smallest <= largest) {
      parts.push_back({number, 0, part.low, middle, part.smallest, largest, part.depth + 1});
    }
    const double smallest = std::max(part.smallest, at[0] + kTolerance);
    if (smallest <= part.largest) {
      parts.push_back({number, 1, middle, part.high, smallest, part.largest, part.depth + 1});
    }
  }
  halvings_.shrink_to_fit();
}

}  // namespace espalier::files
