#include <algorithm>
#include <cmath>

#include "engine/turtle/export/mesh.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

/// A place on a generalized cylinder's axis.
struct AxisSample {
  Vec3 position;
  Vec3 tangent;
  Vec3 turtleUp;  // the turtle's own, interpolated
  double radius = 0.5;
  std::size_t from = 0;  // control points whose contours are blended
  std::size_t to = 0;
  double blend = 0.0;
};

Vec3 headingAt(const GeneralizedCylinder& cylinder, std::size_t i) {
  return cylinder.points[i].frame.heading;
}

AxisSample hermite(const GeneralizedCylinder& cylinder, std::size_t from, std::size_t to, double t) {
  const CylinderPoint& a = cylinder.points[from];
  const CylinderPoint& b = cylinder.points[to];
  const double distance = core::length(b.position - a.position);
  const Vec3 ta = (b.startTangent * distance) * headingAt(cylinder, from);
  const Vec3 tb = (b.endTangent * distance) * headingAt(cylinder, to);
  const double t2 = t * t;
  const double t3 = t2 * t;
  AxisSample sample;
  sample.position = (2.0 * t3 - 3.0 * t2 + 1.0) * a.position + (t3 - 2.0 * t2 + t) * ta +
                    (3.0 * t2 - 2.0 * t3) * b.position + (t3 - t2) * tb;
  sample.tangent = (6.0 * t2 - 6.0 * t) * a.position + (3.0 * t2 - 4.0 * t + 1.0) * ta +
                   (6.0 * t - 6.0 * t2) * b.position + (3.0 * t2 - 2.0 * t) * tb;
  const double r = b.hasSmoothRadius ? 3.0 * t2 - 2.0 * t3 : t;
  sample.radius = 0.5 * (a.width + r * (b.width - a.width));
  if (b.hasSmoothRadius) {
    sample.radius += distance * ((t3 - 2.0 * t2 + t) * b.startRadiusTangent + (t3 - t2) * b.endRadiusTangent);
    sample.radius = std::max(0.0, sample.radius);
  }
  return sample;
}

AxisSample bSpline(const GeneralizedCylinder& cylinder, std::size_t segment, double t) {
  const std::size_t count = cylinder.points.size();
  // an open curve begins and ends at its end points: they count three times
  const auto at = [&](std::size_t k) -> const CylinderPoint& {
    if (cylinder.isClosed) {
      return cylinder.points[(segment + k) % count];
    }
    const std::size_t index = segment + k;
    return cylinder.points[index < 2 ? 0 : std::min(index - 2, count - 1)];
  };
  const double s = 1.0 - t;
  const std::array<double, 4> b{s * s * s / 6.0, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
                                (-3.0 * t * t * t + 3.0 * t * t + 3.0 * t + 1.0) / 6.0, t * t * t / 6.0};
  const std::array<double, 4> d{-s * s / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, (-3.0 * t * t + 2.0 * t + 1.0) / 2.0,
                                t * t / 2.0};
  AxisSample sample;
  sample.radius = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    sample.position = sample.position + b[k] * at(k).position;
    sample.tangent = sample.tangent + d[k] * at(k).position;
    sample.radius += 0.5 * b[k] * at(k).width;
  }
  return sample;
}

std::vector<AxisSample> sampleAxis(const GeneralizedCylinder& cylinder) {
  std::vector<AxisSample> samples;
  const std::size_t count = cylinder.points.size();
  const bool isHermite = cylinder.curve == GeneralizedCylinder::Curve::Hermite;
  const std::size_t segments =
      isHermite ? (cylinder.isClosed ? count : count - 1) : (cylinder.isClosed ? count : count + 1);
  for (std::size_t segment = 0; segment < segments; ++segment) {
    const std::size_t from = isHermite || cylinder.isClosed ? segment : (segment == 0 ? 0 : segment - 1);
    const std::size_t to = cylinder.isClosed ? (segment + 1) % count : std::min(from + 1, count - 1);
    const int strips = cylinder.points[to].stripCount;
    for (int i = segment == 0 ? 0 : 1; i <= strips; ++i) {
      const double t = static_cast<double>(i) / strips;
      AxisSample sample = isHermite ? hermite(cylinder, from, to, t) : bSpline(cylinder, segment, t);
      sample.from = from;
      sample.to = to;
      sample.blend = t;
      sample.turtleUp =
          cylinder.points[from].frame.up + t * (cylinder.points[to].frame.up - cylinder.points[from].frame.up);
      if (core::length(sample.tangent) < 1e-12) {
        sample.tangent = samples.empty() ? headingAt(cylinder, from) : samples.back().tangent;
      }
      sample.tangent = core::normalised(sample.tangent);
      samples.push_back(sample);
    }
  }
  return samples;
}

// the part of `v` normal to the unit vector `axis`, of length 1; any normal when there is none
Vec3 normalPart(const Vec3& v, const Vec3& axis) {
  const Vec3 part = v - core::dot(v, axis) * axis;
  if (core::length(part) > 1e-9) {
    return core::normalised(part);
  }
  const Vec3 other = std::abs(axis.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  return core::normalised(other - core::dot(other, axis) * axis);
}

}  // namespace

void appendCylinder(Mesh& mesh, const GeneralizedCylinder& cylinder, const language::ViewSettings& view) {
  if (cylinder.points.size() < 2) {
    return;
  }
  int sides = 3;
  for (const CylinderPoint& point : cylinder.points) {
    sides = std::max(sides, static_cast<int>(point.sideCount));
  }
  std::vector<std::vector<Vec3>> contours;
  for (const CylinderPoint& point : cylinder.points) {
    contours.push_back(sampleContour(view, point.contour, sides));
  }
  // rings along the axis with the least twist from one to the next
  const std::vector<AxisSample> samples = sampleAxis(cylinder);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(sides);
  Vec3 up;
  double along = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const AxisSample& sample = samples[i];
    if (i == 0 || view.hasTwistOfCylinders) {
      up = normalPart(sample.turtleUp, sample.tangent);
    } else {
      up = normalPart(transported(up, samples[i - 1].tangent, sample.tangent), sample.tangent);
      along += core::length(sample.position - samples[i - 1].position);
    }
    const Vec3 left = core::cross(sample.tangent, up);
    for (std::size_t k = 0; k <= columns; ++k) {
      const Vec3& a = contours[sample.from][k];
      const Vec3& b = contours[sample.to][k];
      const Vec3 p = a + sample.blend * (b - a);
      const Vec3 radial = p.x * up - p.y * left;
      mesh.positions.push_back(sample.position + sample.radius * radial + (sample.radius * p.z) * sample.tangent);
      mesh.normals.push_back(core::length(radial) > 0.0 ? core::normalised(radial) : up);
      mesh.coordinates.push_back({1.0 - static_cast<double>(k) / sides, along});
    }
  }
  for (std::uint32_t row = 0; row + 1 < samples.size(); ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column;
      const std::uint32_t b = a + columns + 1;
      mesh.faces.push_back({a, a + 1, b + 1, b});
    }
  }
}

}  // namespace espalier::turtle
