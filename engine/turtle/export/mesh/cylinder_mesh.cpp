#include "engine/turtle/export/mesh/cylinder_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/core/polygon.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

Vec3 headingAt(const GeneralizedCylinder& cylinder, std::size_t i) {
  return cylinder.points[i].frame.heading;
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
    if (runs.empty() || runs.back().colour != colour || runs.back().count == kLongestRun) {
      runs.push_back({stretch, 0, colour});
    }
    ++runs.back().count;
  }
  return runs;
}

SweptCylinder::AxisSample SweptCylinder::hermite(std::size_t from, std::size_t to, double t) const {
  const CylinderPoint& a = cylinder_.points[from];
  const CylinderPoint& b = cylinder_.points[to];
  const double distance = core::length(b.position - a.position);
  const Vec3 ta = (b.startTangent * distance) * headingAt(cylinder_, from);
  const Vec3 tb = (b.endTangent * distance) * headingAt(cylinder_, to);
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

SweptCylinder::AxisSample SweptCylinder::bSpline(std::size_t segment, double t) const {
  const std::size_t count = cylinder_.points.size();
  // an open curve begins and ends at its end points: they count three times
  const auto at = [&](std::size_t k) -> const CylinderPoint& {
    if (cylinder_.isClosed) {
      return cylinder_.points[(segment + k) % count];
    }
    const std::size_t index = segment + k;
    return cylinder_.points[index < 2 ? 0 : std::min(index - 2, count - 1)];
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

void SweptCylinder::sampleAxis(double detail) {
  const bool isHermite = cylinder_.curve == GeneralizedCylinder::Curve::Hermite;
  const std::size_t stretchCount = stretchCountOf(cylinder_);
  for (std::size_t segment = 0; segment < stretchCount; ++segment) {
    const auto [from, to] = endsOf(cylinder_, segment);
    const int strips = atDetail(cylinder_.points[to].stripCount, detail, 1);
    for (int i = segment == 0 ? 0 : 1; i <= strips; ++i) {
      const double t = static_cast<double>(i) / strips;
      AxisSample sample = isHermite ? hermite(from, to, t) : bSpline(segment, t);
      sample.stretch = segment;
      sample.from = from;
      sample.to = to;
      sample.blend = t;
      sample.turtleUp =
          cylinder_.points[from].frame.up + t * (cylinder_.points[to].frame.up - cylinder_.points[from].frame.up);
      if (core::length(sample.tangent) < 1e-12) {
        sample.tangent = samples_.empty() ? headingAt(cylinder_, from) : samples_.back().tangent;
      }
      sample.tangent = core::normalised(sample.tangent);
      samples_.push_back(sample);
    }
  }
}

// the normal carried to the next sample without rotation about the axis: two reflections (Wang, Juettler, Zheng & Liu
// 2008, "Computation of rotation minimizing frames", section 3), of fourth order in the distance of the samples
Vec3 SweptCylinder::carried(const Vec3& up, const AxisSample& from, const AxisSample& to) {
  const Vec3 chord = to.position - from.position;
  const Vec3 tangent = reflected(from.tangent, chord);
  return normalPart(reflected(reflected(up, chord), to.tangent - tangent), to.tangent);
}

// normals of the axis at all samples, as the turtle's own or with the least twist; those of a closed axis meet
void SweptCylinder::carryNormals(bool hasTurtleTwist) {
  std::vector<double> lengths{0.0};
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    ups_.push_back(i == 0 || hasTurtleTwist ? normalPart(samples_[i].turtleUp, samples_[i].tangent)
                                            : carried(ups_.back(), samples_[i - 1], samples_[i]));
    if (i > 0) {
      lengths.push_back(lengths.back() + core::length(samples_[i].position - samples_[i - 1].position));
    }
  }
  if (cylinder_.isClosed && !hasTurtleTwist && lengths.back() > 0.0) {
    // the turn of the frame after one round is taken back evenly along it
    const Vec3& tangent = samples_.front().tangent;
    const double angle =
        core::atan2(core::dot(core::cross(ups_.back(), ups_.front()), tangent), core::dot(ups_.back(), ups_.front()));
    for (std::size_t i = 0; i < ups_.size(); ++i) {
      ups_[i] = rotatedAbout(ups_[i], samples_[i].tangent, angle * lengths[i] / lengths.back());
    }
  }
}

// second texture coordinates; `ratio` above 0: in pictures
void SweptCylinder::measure(double ratio) {
  double along = 0.0;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (i > 0) {
      const double circumference = std::numbers::pi * (samples_[i].radius + samples_[i - 1].radius);
      const double unit = ratio > 0.0 ? ratio * circumference : 1.0;
      along += unit > 0.0 ? core::length(samples_[i].position - samples_[i - 1].position) / unit : 0.0;
    }
    along_.push_back(along);
  }
}

// radius lost per unit of length at a sample
double SweptCylinder::slopeAt(std::size_t i) const {
  const AxisSample& before = samples_[i > 0 ? i - 1 : 0];
  const AxisSample& after = samples_[std::min(i + 1, samples_.size() - 1)];
  const double length =
      core::length(samples_[i].position - before.position) + core::length(after.position - samples_[i].position);
  return length > 0.0 ? (before.radius - after.radius) / length : 0.0;
}

// the sample with which a stretch begins, which the one before it ends with
std::size_t SweptCylinder::firstSampleOf(std::size_t stretch) const {
  const auto found = std::ranges::lower_bound(samples_, stretch, {}, &AxisSample::stretch);
  const auto index = static_cast<std::size_t>(found - samples_.begin());
  return index > 0 ? index - 1 : 0;
}

void SweptCylinder::sampleContours(const files::ViewSettings& view) {
  std::map<std::int32_t, std::uint32_t> numbers;
  for (const CylinderPoint& point : cylinder_.points) {
    const auto [known, isNew] = numbers.try_emplace(point.contour, static_cast<std::uint32_t>(contours_.size()));
    if (isNew) {
      contours_.push_back(sampleContour(view, point.contour, sides_));
      isTube_ = isTube_ && contours_.back().front() == contours_.back().back();
    }
    contourNumbers_.push_back(known->second);
  }
}

SweptCylinder::SweptCylinder(const GeneralizedCylinder& cylinder, const files::ViewSettings& view, double detail)
    : cylinder_(cylinder), runs_(runsOf(cylinder)) {
  if (runs_.empty()) {
    return;
  }
  for (const CylinderPoint& point : cylinder.points) {
    sides_ = std::max(sides_, static_cast<int>(point.sideCount));
  }
  sides_ = atDetail(sides_, detail, 3);
  sampleContours(view);
  sampleAxis(detail);
  carryNormals(view.hasTwistOfCylinders);
  measure(cylinder.texture > 0 ? view.textures[static_cast<std::size_t>(cylinder.texture) - 1].ratio : 0.0);
}

std::size_t SweptCylinder::faceCountOf(const CylinderRun& run) const {
  const std::size_t rows = firstSampleOf(run.first + run.count) - firstSampleOf(run.first);
  return rows * static_cast<std::size_t>(sides_);
}

void SweptCylinder::appendRun(Mesh& mesh, const CylinderRun& run) const {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(sides_);
  const std::size_t begin = firstSampleOf(run.first);
  const std::size_t end = firstSampleOf(run.first + run.count) + 1;
  bool isTurned = false;
  for (std::size_t i = begin; i < end; ++i) {
    // a closed axis ends exactly where it began
    const std::size_t at = cylinder_.isClosed && i + 1 == samples_.size() ? 0 : i;
    const AxisSample& ring = samples_[at];
    const Vec3& up = ups_[at];
    const Vec3 left = core::cross(ring.tangent, up);
    const Section section = sectionOf(contourOf(ring.from), contourOf(ring.to), ring.blend);
    const double slope = slopeAt(at);
    isTurned = section.isCounterClockwise;
    for (std::size_t k = 0; k <= columns; ++k) {
      const Vec3& p = section.points[k];
      const Vec3& n = section.normals[k];
      const double tilt = slope * (p.x * n.x + p.y * n.y);
      mesh.positions.push_back(ring.position + ring.radius * (p.x * up - p.y * left + p.z * ring.tangent));
      mesh.normals.push_back(core::normalised(n.x * up - n.y * left + tilt * ring.tangent));
      mesh.coordinates.push_back({1.0 - static_cast<double>(k) / sides_, along_[i]});
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
  if (!cylinder_.isClosed && isTube_) {
    if (begin == 0) {
      appendCap(mesh, first, columns, -samples_.front().tangent);
    }
    if (end == samples_.size()) {
      appendCap(mesh, first + (rows - 1) * (columns + 1), columns, samples_.back().tangent);
    }
  }
}

}  // namespace espalier::turtle
