#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/check.h"
#include "engine/files/curves/b_spline.h"
#include "engine/files/view_settings.h"

namespace espalier::files {
namespace {

using core::Vec3;

// the raw parameter stops this share before the end, so that it stays in the last segment
constexpr double kEndCut = 1e-6;

Vec3 mix(const std::vector<Vec3>& points, const BSplineWeights& spline) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    sum = sum + points[spline.first + i] * spline.weights[i];
  }
  return sum;
}

Vec3 bezier(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double u) {
  const double v = 1.0 - u;
  return a * (v * v * v) + b * (3.0 * v * v * u) + c * (3.0 * v * u * u) + d * (u * u * u);
}

}  // namespace

ParametricCurve::ParametricCurve(Kind kind, std::vector<core::Vec3> points, int sampleCount)
    : kind_(kind), points_(std::move(points)) {
  ESPALIER_CHECK(points_.size() >= (kind_ == Kind::BezierSurface ? kPatchPoints : 4));
  // turn the closed and the phantom form into the plain form
  if (kind_ == Kind::BSplineClosed) {
    for (std::size_t i = 0; i < 3; ++i) {
      points_.push_back(Vec3(points_[i]));
    }
  } else if (kind_ == Kind::BSplinePhantom) {
    const std::size_t last = points_.size() - 1;
    const Vec3 before = points_[0] * 2.0 - points_[1];
    const Vec3 after = points_[last] * 2.0 - points_[last - 1];
    points_.insert(points_.begin(), before);
    points_.push_back(after);
  }
  // chord lengths at equidistant parameters
  const std::size_t count = static_cast<std::size_t>(std::max(sampleCount, 2));
  cumulative_.reserve(count);
  cumulative_.push_back(0.0);
  Vec3 last = rawPoint(0.0);
  for (std::size_t i = 1; i < count; ++i) {
    const Vec3 next = rawPoint(static_cast<double>(i) / static_cast<double>(count - 1));
    arcLength_ += core::length(next - last);
    cumulative_.push_back(arcLength_);
    last = next;
  }
  if (arcLength_ > 0.0) {
    for (double& length : cumulative_) {
      length /= arcLength_;
    }
  }
}

core::Vec3 ParametricCurve::point(double t) const {
  // written so that NaN becomes 0
  const double clamped = t > 0.0 ? std::min(t, 1.0) : 0.0;
  const auto above = std::upper_bound(cumulative_.begin(), cumulative_.end(), clamped);
  const std::size_t i = std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - cumulative_.begin(), 1)) - 1,
                                 cumulative_.size() - 2);
  const double width = cumulative_[i + 1] - cumulative_[i];
  const double share = width > 0.0 ? std::clamp((clamped - cumulative_[i]) / width, 0.0, 1.0) : 0.0;
  return rawPoint((static_cast<double>(i) + share) / static_cast<double>(cumulative_.size() - 1));
}

core::Vec3 ParametricCurve::rawPoint(double p) const {
  const double parameter = std::clamp(p, 0.0, 1.0) * (1.0 - kEndCut);
  switch (kind_) {
    case Kind::BSpline:
    case Kind::BSplineClosed:
    case Kind::BSplinePhantom: {
      const std::size_t segments = points_.size() - 3;
      const double place = parameter * static_cast<double>(segments);
      const std::size_t segment = std::min(static_cast<std::size_t>(place), segments - 1);
      return mix(points_, uniformBSplineWeights(segment, place - static_cast<double>(segment)));
    }
    case Kind::BSplineEndPoint:
      return mix(points_, clampedBSplineWeights(points_.size(), parameter));
    case Kind::Bezier: {
      const std::size_t segments = 1 + (points_.size() - 4) / 3;
      const double place = parameter * static_cast<double>(segments);
      const std::size_t segment = std::min(static_cast<std::size_t>(place), segments - 1);
      const Vec3* const first = points_.data() + segment * 3;
      return bezier(first[0], first[1], first[2], first[3], place - static_cast<double>(segment));
    }
    case Kind::BezierSurface:
      // the patch's edge where the second parameter is 0: the first point of every row
      return bezier(points_[0], points_[4], points_[8], points_[12], parameter);
  }
  return {};
}

}  // namespace espalier::files
