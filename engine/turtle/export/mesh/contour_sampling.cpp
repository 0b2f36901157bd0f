#include <algorithm>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr int kSamplesPerSegment = 10;

Vec3 uniformBSpline(const std::vector<Vec3>& points, std::size_t segment, double t) {
  const auto at = [&](std::size_t k) -> const Vec3& { return points[(segment + k) % points.size()]; };
  const double s = 1.0 - t;
  const double b0 = s * s * s / 6.0;
  const double b1 = (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0;
  const double b2 = (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0;
  const double b3 = t * t * t / 6.0;
  return b0 * at(0) + b1 * at(1) + b2 * at(2) + b3 * at(3);
}

}  // namespace

std::vector<Vec3> sampleContour(const files::ViewSettings& view, std::int32_t id, int sides) {
  std::vector<Vec3> samples;
  const auto contour =
      std::find_if(view.contours.begin(), view.contours.end(), [id](const files::Contour& c) { return c.id == id; });
  const bool isDefined = id != 0 && contour != view.contours.end() && contour->points.size() >= 4;
  if (!isDefined) {
    for (int k = 0; k <= sides; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k % sides) / sides;
      samples.push_back({core::cos(angle), core::sin(angle), 0.0});
    }
    return samples;
  }
  // ten points a segment, then equal lengths in x and y
  const std::size_t segments = contour->isClosed ? contour->points.size() : contour->points.size() - 3;
  std::vector<Vec3> fine;
  std::vector<double> length{0.0};
  for (std::size_t i = 0; i <= segments * kSamplesPerSegment; ++i) {
    const std::size_t segment = std::min(i / kSamplesPerSegment, segments - 1);
    const double t = static_cast<double>(i) / kSamplesPerSegment - static_cast<double>(segment);
    fine.push_back(uniformBSpline(contour->points, segment, t));
    if (i > 0) {
      length.push_back(length.back() + core::hypot(fine[i].x - fine[i - 1].x, fine[i].y - fine[i - 1].y));
    }
  }
  std::size_t k = 1;
  for (int i = 0; i <= sides; ++i) {
    const double wanted = length.back() * i / sides;
    while (k + 1 < fine.size() && length[k] < wanted) {
      ++k;
    }
    const double span = length[k] - length[k - 1];
    const double t = span > 0.0 ? std::clamp((wanted - length[k - 1]) / span, 0.0, 1.0) : 0.0;
    samples.push_back(fine[k - 1] + t * (fine[k] - fine[k - 1]));
  }
  if (contour->isClosed) {
    // the curve's start goes to +x
    const double angle = -core::atan2(samples.front().y, samples.front().x);
    for (Vec3& p : samples) {
      p = {core::cos(angle) * p.x - core::sin(angle) * p.y, core::sin(angle) * p.x + core::cos(angle) * p.y, p.z};
    }
    samples.back() = samples.front();
  }
  return samples;
}

}  // namespace espalier::turtle
