#include "engine/core/polygon.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/work_meter.h"

namespace espalier::core {

namespace {

using Point = std::array<double, 2>;

// twice the signed area of a triangle
double doubleArea(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// the plane's axes, right-handed with the unit vector `normal`
std::array<Vec3, 2> planeAxes(const Vec3& normal) {
  const Vec3 other = std::abs(normal.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  const Vec3 u = normalised(cross(other, normal));
  return {u, cross(normal, u)};
}

/// Points in the cells of a grid, to find those near a triangle. A point is in it once.
class PointGrid {
 public:
  explicit PointGrid(const std::vector<Point>& points)
      : points_(points),
        side_(static_cast<std::uint32_t>(std::clamp(std::sqrt(static_cast<double>(points.size())), 1.0, kMostCells))),
        low_(points[0]),
        first_(std::size_t{side_} * side_, kNone),
        next_(points.size(), kNone),
        before_(points.size(), kNone) {
    Point high = low_;
    for (const Point& p : points) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low_[axis] = std::min(low_[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double extent = high[axis] - low_[axis];
      scale_[axis] = extent > 0.0 ? side_ / extent : 0.0;
    }
  }

  void insert(std::uint32_t point) {
    std::uint32_t& first = first_[cellOf(points_[point])];
    before_[point] = kNone;
    next_[point] = first;
    if (first != kNone) {
      before_[first] = point;
    }
    first = point;
  }

  void remove(std::uint32_t point) {
    const std::uint32_t before = before_[point];
    const std::uint32_t next = next_[point];
    (before != kNone ? next_[before] : first_[cellOf(points_[point])]) = next;
    if (next != kNone) {
      before_[next] = before;
    }
  }

  /// Whether `holds` of any point in the cells that a triangle's bounds touch.
  template <typename Holds>
  [[nodiscard]] bool anyNear(const Point& a, const Point& b, const Point& c, const Holds& holds) const {
    const std::uint32_t left = placeOf(std::min({a[0], b[0], c[0]}), 0);
    const std::uint32_t right = placeOf(std::max({a[0], b[0], c[0]}), 0);
    const std::uint32_t top = placeOf(std::max({a[1], b[1], c[1]}), 1);
    for (std::uint32_t row = placeOf(std::min({a[1], b[1], c[1]}), 1); row <= top; ++row) {
      for (std::uint32_t column = left; column <= right; ++column) {
        for (std::uint32_t k = first_[std::size_t{row} * side_ + column]; k != kNone; k = next_[k]) {
          if (holds(k)) {
            return true;
          }
        }
      }
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  static constexpr double kMostCells = 1024.0;  // of a side

  // never falls where the coordinate grows
  [[nodiscard]] std::uint32_t placeOf(double coordinate, std::size_t axis) const {
    return std::min(static_cast<std::uint32_t>((coordinate - low_[axis]) * scale_[axis]), side_ - 1);
  }
  [[nodiscard]] std::size_t cellOf(const Point& p) const {
    return std::size_t{placeOf(p[1], 1)} * side_ + placeOf(p[0], 0);
  }

  const std::vector<Point>& points_;
  std::uint32_t side_;  // cells
  Point low_;
  Point scale_{};                             // cells per unit
  std::vector<std::uint32_t> first_;          // by cell
  std::vector<std::uint32_t> next_, before_;  // in the cell, by point
};

constexpr std::size_t kLargePolygon = 64;            // corners from which a grid saves more than it costs
constexpr std::uint32_t kCornersBetweenPolls = 256;  // looked at

/// The rest of a polygon while ears are cut off: a ring of vertices.
class EarClipper {
 public:
  explicit EarClipper(const std::vector<Point>& points)
      : points_(points), next_(points.size()), before_(points.size()) {
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_[i] = (i + 1) % count;
      before_[i] = (i + count - 1) % count;
    }
    if (count < kLargePolygon) {
      return;
    }
    hollows_.emplace(points);
    isHollow_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      updateHollow(i);
    }
  }

  [[nodiscard]] std::vector<std::array<std::uint32_t, 3>> clip();

 private:
  [[nodiscard]] double turnAt(std::uint32_t i) const {
    return doubleArea(points_[before_[i]], points_[i], points_[next_[i]]);
  }
  [[nodiscard]] bool isEar(std::uint32_t i) const;
  void cutOff(std::uint32_t i);
  void updateHollow(std::uint32_t i);

  const std::vector<Point>& points_;
  std::vector<std::uint32_t> next_, before_;
  // of a large polygon: the corners of the ring that are not convex; only these can lie in an ear
  std::optional<PointGrid> hollows_;
  std::vector<bool> isHollow_;
};

void EarClipper::updateHollow(std::uint32_t i) {
  const bool isHollow = !(turnAt(i) > 0.0);
  if (isHollow != isHollow_[i]) {
    isHollow ? hollows_->insert(i) : hollows_->remove(i);
    isHollow_[i] = isHollow;
  }
}

void EarClipper::cutOff(std::uint32_t i) {
  next_[before_[i]] = next_[i];
  before_[next_[i]] = before_[i];
  if (hollows_) {
    if (isHollow_[i]) {
      hollows_->remove(i);
    }
    updateHollow(before_[i]);
    updateHollow(next_[i]);
  }
}

// convex, and no other vertex inside or on the triangle
bool EarClipper::isEar(std::uint32_t i) const {
  const Point& a = points_[before_[i]];
  const Point& b = points_[i];
  const Point& c = points_[next_[i]];
  if (!(doubleArea(a, b, c) > 0.0)) {
    return false;
  }
  const auto isInside = [&](std::uint32_t k) {
    const Point& p = points_[k];
    // a vertex at a corner is allowed: polygons may touch themselves
    return p != a && p != b && p != c && doubleArea(a, b, p) >= 0.0 && doubleArea(b, c, p) >= 0.0 &&
           doubleArea(c, a, p) >= 0.0;
  };
  if (hollows_) {
    return !hollows_->anyNear(a, b, c, isInside);
  }
  for (std::uint32_t k = next_[next_[i]]; k != before_[i]; k = next_[k]) {
    if (!(turnAt(k) > 0.0) && isInside(k)) {
      return false;
    }
  }
  return true;
}

std::vector<std::array<std::uint32_t, 3>> EarClipper::clip() {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  auto left = static_cast<std::uint32_t>(points_.size());
  triangles.reserve(left);
  std::uint32_t at = 0;
  std::uint32_t tried = 0;
  std::uint32_t bestFallback = 0;
  std::uint32_t looks = 0;
  while (left > 3) {
    if (++looks % kCornersBetweenPolls == 0) {
      pollWork();
    }
    const bool isFlat = turnAt(at) == 0.0;
    if (isFlat || isEar(at) || tried == left) {
      // a polygon that crosses itself may have no ear: cut off the corner that turns most
      const std::uint32_t cut = tried == left ? bestFallback : at;
      triangles.push_back({before_[cut], cut, next_[cut]});
      cutOff(cut);
      at = next_[next_[cut]];
      --left;
      tried = 0;
      bestFallback = at;
      continue;
    }
    if (turnAt(at) > turnAt(bestFallback)) {
      bestFallback = at;
    }
    at = next_[at];
    ++tried;
  }
  triangles.push_back({before_[at], at, next_[at]});
  return triangles;
}

}  // namespace

Vec3 newellNormal(std::span<const Vec3> vertices) {
  Vec3 normal;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    normal = normal + cross(vertices[i] - vertices[0], vertices[(i + 1) % vertices.size()] - vertices[0]);
  }
  return normal;
}

std::vector<std::array<double, 2>> projectedCorners(std::span<const Vec3> vertices, const Vec3& normal) {
  const auto [u, v] = planeAxes(normal);
  std::vector<Point> points;
  points.reserve(vertices.size());
  // relative to the first vertex, so that areas far from the origin keep their digits
  for (const Vec3& vertex : vertices) {
    points.push_back({dot(vertex - vertices[0], u), dot(vertex - vertices[0], v)});
  }
  return points;
}

std::vector<std::array<std::uint32_t, 3>> triangulate(std::span<const Vec3> vertices, const Vec3& normal) {
  if (vertices.size() < 3) {
    return {};
  }
  const std::vector<Point> points = projectedCorners(vertices, normalised(normal));
  return EarClipper(points).clip();
}

}  // namespace espalier::core
