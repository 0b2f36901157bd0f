#include "engine/core/polygon.h"

#include <cmath>

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
  }

  [[nodiscard]] std::vector<std::array<std::uint32_t, 3>> clip();

 private:
  [[nodiscard]] double turnAt(std::uint32_t i) const {
    return doubleArea(points_[before_[i]], points_[i], points_[next_[i]]);
  }
  [[nodiscard]] bool isEar(std::uint32_t i) const;

  const std::vector<Point>& points_;
  std::vector<std::uint32_t> next_, before_;
};

// convex, and no other vertex inside or on the triangle
bool EarClipper::isEar(std::uint32_t i) const {
  const Point& a = points_[before_[i]];
  const Point& b = points_[i];
  const Point& c = points_[next_[i]];
  if (!(doubleArea(a, b, c) > 0.0)) {
    return false;
  }
  for (std::uint32_t k = next_[next_[i]]; k != before_[i]; k = next_[k]) {
    const Point& p = points_[k];
    // a vertex at a corner is allowed: polygons may touch themselves
    if (p == a || p == b || p == c || turnAt(k) > 0.0) {
      continue;
    }
    if (doubleArea(a, b, p) >= 0.0 && doubleArea(b, c, p) >= 0.0 && doubleArea(c, a, p) >= 0.0) {
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
  while (left > 3) {
    const bool isFlat = turnAt(at) == 0.0;
    if (isFlat || isEar(at) || tried == left) {
      // a polygon that crosses itself may have no ear: cut off the corner that turns most
      const std::uint32_t cut = tried == left ? bestFallback : at;
      triangles.push_back({before_[cut], cut, next_[cut]});
      next_[before_[cut]] = next_[cut];
      before_[next_[cut]] = before_[cut];
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
