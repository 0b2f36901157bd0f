#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/core/polygon.h"
#include "engine/turtle/export/mesh/mesh.h"
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
  std::size_t stretch = 0;  // that ends here or goes on beyond
  std::size_t from = 0;     // control points whose contours are blended
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

std::size_t stretchCountOf(const GeneralizedCylinder& cylinder) {
  const std::size_t count = cylinder.points.size();
  const bool isHermite = cylinder.curve == GeneralizedCylinder::Curve::Hermite;
  return isHermite ? (cylinder.isClosed ? count : count - 1) : (cylinder.isClosed ? count : count + 1);
}

// the control points between which a stretch lies, or that it is nearest to
std::pair<std::size_t, std::size_t> endsOf(const GeneralizedCylinder& cylinder, std::size_t stretch) {
  const std::size_t count = cylinder.points.size();
  const bool isHermite = cylinder.curve == GeneralizedCylinder::Curve::Hermite;
  const std::size_t from = isHermite || cylinder.isClosed ? stretch : (stretch == 0 ? 0 : stretch - 1);
  return {from, cylinder.isClosed ? (stretch + 1) % count : std::min(from + 1, count - 1)};
}

std::vector<AxisSample> sampleAxis(const GeneralizedCylinder& cylinder, double detail) {
  std::vector<AxisSample> samples;
  const bool isHermite = cylinder.curve == GeneralizedCylinder::Curve::Hermite;
  const std::size_t stretchCount = stretchCountOf(cylinder);
  for (std::size_t segment = 0; segment < stretchCount; ++segment) {
    const auto [from, to] = endsOf(cylinder, segment);
    const int strips = atDetail(cylinder.points[to].stripCount, detail, 1);
    for (int i = segment == 0 ? 0 : 1; i <= strips; ++i) {
      const double t = static_cast<double>(i) / strips;
      AxisSample sample = isHermite ? hermite(cylinder, from, to, t) : bSpline(cylinder, segment, t);
      sample.stretch = segment;
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

Vec3 reflected(const Vec3& v, const Vec3& mirror) {
  const double square = core::dot(mirror, mirror);
  return square > 0.0 ? v - (2.0 * core::dot(mirror, v) / square) * mirror : v;
}

// the normal carried to the next sample without rotation about the axis: two reflections (Wang, Juettler, Zheng & Liu
// 2008, "Computation of rotation minimizing frames", section 3), of fourth order in the distance of the samples
Vec3 carried(const Vec3& up, const AxisSample& from, const AxisSample& to) {
  const Vec3 chord = to.position - from.position;
  const Vec3 tangent = reflected(from.tangent, chord);
  return normalPart(reflected(reflected(up, chord), to.tangent - tangent), to.tangent);
}

// normals of the axis at all samples, as the turtle's own or with the least twist; those of a closed axis meet
std::vector<Vec3> normalsAlong(const std::vector<AxisSample>& samples, bool isClosed, bool hasTurtleTwist) {
  std::vector<Vec3> ups;
  std::vector<double> along{0.0};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ups.push_back(i == 0 || hasTurtleTwist ? normalPart(samples[i].turtleUp, samples[i].tangent)
                                           : carried(ups.back(), samples[i - 1], samples[i]));
    if (i > 0) {
      along.push_back(along.back() + core::length(samples[i].position - samples[i - 1].position));
    }
  }
  if (isClosed && !hasTurtleTwist && along.back() > 0.0) {
    // the turn of the frame after one round is taken back evenly along it
    const Vec3& tangent = samples.front().tangent;
    const double angle =
        core::atan2(core::dot(core::cross(ups.back(), ups.front()), tangent), core::dot(ups.back(), ups.front()));
    for (std::size_t i = 0; i < ups.size(); ++i) {
      ups[i] = rotatedAbout(ups[i], samples[i].tangent, angle * along[i] / along.back());
    }
  }
  return ups;
}

/// The section of a cylinder at one sample: points in units of the radius and their outward normals, in x and y.
struct Section {
  std::vector<Vec3> points;
  std::vector<Vec3> normals;
  bool isCounterClockwise = true;
};

Section sectionOf(const std::vector<Vec3>& from, const std::vector<Vec3>& to, double blend) {
  Section section;
  double doubleArea = 0.0;
  for (std::size_t k = 0; k < from.size(); ++k) {
    section.points.push_back(from[k] + blend * (to[k] - from[k]));
    if (k > 0) {
      doubleArea += section.points[k - 1].x * section.points[k].y - section.points[k - 1].y * section.points[k].x;
    }
  }
  section.isCounterClockwise = doubleArea >= 0.0;
  const double sense = section.isCounterClockwise ? 1.0 : -1.0;
  const std::size_t last = section.points.size() - 1;
  const bool isClosed = section.points[0] == section.points[last];
  for (std::size_t k = 0; k <= last; ++k) {
    // across the neighbours; those of a closed section go on over its seam
    const Vec3& before = section.points[k > 0 ? k - 1 : (isClosed ? last - 1 : 0)];
    const Vec3& after = section.points[k < last ? k + 1 : (isClosed ? 1 : last)];
    const Vec3 normal{sense * (after.y - before.y), -sense * (after.x - before.x), 0.0};
    section.normals.push_back(core::length(normal) > 0.0 ? core::normalised(normal) : Vec3{1.0, 0.0, 0.0});
  }
  return section;
}

// radius lost per unit of length at a sample
double slopeAt(const std::vector<AxisSample>& samples, std::size_t i) {
  const AxisSample& before = samples[i > 0 ? i - 1 : 0];
  const AxisSample& after = samples[std::min(i + 1, samples.size() - 1)];
  const double length =
      core::length(samples[i].position - before.position) + core::length(after.position - samples[i].position);
  return length > 0.0 ? (before.radius - after.radius) / length : 0.0;
}

// the sample with which a stretch begins, which the one before it ends with
std::size_t firstSampleOf(const std::vector<AxisSample>& samples, std::size_t stretch) {
  const auto found = std::ranges::find_if(samples, [stretch](const AxisSample& s) { return s.stretch >= stretch; });
  const auto index = static_cast<std::size_t>(found - samples.begin());
  return index > 0 ? index - 1 : 0;
}

// a flat end over the ring of `columns` vertices that begins at `first`
void appendCap(Mesh& mesh, std::uint32_t first, std::uint32_t columns, const Vec3& outward) {
  const auto begin = mesh.positions.begin() + first;
  const std::vector<Vec3> rim(begin, begin + columns);
  const Vec3 normal = core::newellNormal(rim);
  if (!(core::length(normal) > 0.0)) {
    return;
  }
  const auto cap = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t k = 0; k < columns; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / columns;
    mesh.positions.push_back(rim[k]);
    mesh.normals.push_back(outward);
    mesh.coordinates.push_back({0.5 + 0.5 * core::cos(angle), 0.5 + 0.5 * core::sin(angle)});
  }
  const bool isTurned = core::dot(normal, outward) < 0.0;
  for (const auto& triangle : core::triangulate(rim, normal)) {
    mesh.faces.push_back(
        {cap + triangle[0], cap + triangle[isTurned ? 2 : 1], cap + triangle[isTurned ? 1 : 2], Mesh::kNoVertex});
  }
}

}  // namespace

std::vector<CylinderRun> runsOf(const GeneralizedCylinder& cylinder) {
  std::vector<CylinderRun> runs;
  for (std::size_t stretch = 0; cylinder.points.size() >= 2 && stretch < stretchCountOf(cylinder); ++stretch) {
    const std::int32_t colour = cylinder.points[endsOf(cylinder, stretch).second].colour;
    if (runs.empty() || runs.back().colour != colour) {
      runs.push_back({stretch, 0, colour});
    }
    ++runs.back().count;
  }
  return runs;
}

void appendCylinder(Mesh& mesh, const GeneralizedCylinder& cylinder, const files::ViewSettings& view, double detail) {
  for (const CylinderRun& run : runsOf(cylinder)) {
    appendCylinder(mesh, cylinder, run, view, detail);
  }
}

void appendCylinder(Mesh& mesh, const GeneralizedCylinder& cylinder, const CylinderRun& run,
                    const files::ViewSettings& view, double detail) {
  int sides = 3;
  for (const CylinderPoint& point : cylinder.points) {
    sides = std::max(sides, static_cast<int>(point.sideCount));
  }
  sides = atDetail(sides, detail, 3);
  std::vector<std::vector<Vec3>> contours;
  for (const CylinderPoint& point : cylinder.points) {
    contours.push_back(sampleContour(view, point.contour, sides));
  }
  const double ratio = cylinder.texture > 0 ? view.textures[static_cast<std::size_t>(cylinder.texture) - 1].ratio : 0.0;

  // rings along the axis, those of the run kept
  const std::vector<AxisSample> samples = sampleAxis(cylinder, detail);
  const std::vector<Vec3> ups = normalsAlong(samples, cylinder.isClosed, view.hasTwistOfCylinders);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(sides);
  const std::size_t begin = firstSampleOf(samples, run.first);
  const std::size_t end = firstSampleOf(samples, run.first + run.count) + 1;
  double along = 0.0;
  bool isTurned = false;
  for (std::size_t i = 0; i < end; ++i) {
    const AxisSample& sample = samples[i];
    if (i > 0) {
      const double circumference = std::numbers::pi * (sample.radius + samples[i - 1].radius);
      const double unit = ratio > 0.0 ? ratio * circumference : 1.0;
      along += unit > 0.0 ? core::length(sample.position - samples[i - 1].position) / unit : 0.0;
    }
    if (i < begin) {
      continue;
    }
    // a closed axis ends exactly where it began
    const std::size_t at = cylinder.isClosed && i + 1 == samples.size() ? 0 : i;
    const AxisSample& ring = samples[at];
    const Vec3 left = core::cross(ring.tangent, ups[at]);
    const Section section = sectionOf(contours[ring.from], contours[ring.to], ring.blend);
    const double slope = slopeAt(samples, at);
    isTurned = section.isCounterClockwise;
    for (std::size_t k = 0; k <= columns; ++k) {
      const Vec3& p = section.points[k];
      const Vec3& n = section.normals[k];
      const double tilt = slope * (p.x * n.x + p.y * n.y);
      mesh.positions.push_back(ring.position + ring.radius * (p.x * ups[at] - p.y * left + p.z * ring.tangent));
      mesh.normals.push_back(core::normalised(n.x * ups[at] - n.y * left + tilt * ring.tangent));
      mesh.coordinates.push_back({1.0 - static_cast<double>(k) / sides, along});
    }
  }

  // counter-clockwise sections run clockwise about the axis: x is along U, y against L
  const auto rows = static_cast<std::uint32_t>(end - begin);
  for (std::uint32_t row = 0; row + 1 < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column;
      const std::uint32_t b = a + columns + 1;
      mesh.faces.push_back(isTurned ? std::array{a, b, b + 1, a + 1} : std::array{a, a + 1, b + 1, b});
    }
  }
  const auto isTube = [](const std::vector<Vec3>& contour) { return contour.front() == contour.back(); };
  if (!cylinder.isClosed && std::ranges::all_of(contours, isTube)) {
    if (begin == 0) {
      appendCap(mesh, first, columns, -samples.front().tangent);
    }
    if (end == samples.size()) {
      appendCap(mesh, first + (rows - 1) * (columns + 1), columns, samples.back().tangent);
    }
  }
}

}  // namespace espalier::turtle
