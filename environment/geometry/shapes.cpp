#include "environment/geometry/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace espalier::environment {

namespace {

using core::cross;
using core::dot;
using core::Vec3;

Vec3 least(const Vec3& a, const Vec3& b) {
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vec3 most(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

/// Any unit vector across v.
Vec3 acrossOf(const Vec3& v) {
  const Vec3 axis = std::abs(v.x) < std::abs(v.y) ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  const Vec3 across = cross(v, axis);
  return core::length(across) > 0.0 ? core::normalised(across) : Vec3{0.0, 0.0, 1.0};
}

/// The surface of a ball around `centre`; at the centre the direction is `otherwise`.
SurfacePoint nearestOnBall(const Vec3& centre, double radius, const Vec3& p, const Vec3& otherwise) {
  const Vec3 way = p - centre;
  const double distance = core::length(way);
  const Vec3 normal = distance > 0.0 ? way * (1.0 / distance) : otherwise;
  return {distance - radius, centre + normal * radius, normal};
}

Vec3 clampedTo(const Bounds& box, const Vec3& p) {
  return most(box.low, least(p, box.high));
}

}  // namespace

Bounds boundsOf(const Sphere& sphere) {
  const Vec3 r{sphere.radius, sphere.radius, sphere.radius};
  return {sphere.centre - r, sphere.centre + r};
}

Bounds boundsOf(const Capsule& capsule) {
  const Vec3 r{capsule.radius, capsule.radius, capsule.radius};
  return {least(capsule.a, capsule.b) - r, most(capsule.a, capsule.b) + r};
}

Bounds boundsOf(const Triangle& triangle) {
  const auto& [a, b, c] = triangle.corners;
  return {least(a, least(b, c)), most(a, most(b, c))};
}

Vec3 nearestOnSegment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 way = b - a;
  const double squared = dot(way, way);
  const double t = squared > 0.0 ? std::clamp(dot(p - a, way) / squared, 0.0, 1.0) : 0.0;
  return a + way * t;
}

TrianglePoint nearestOnTriangle(const Triangle& triangle, const Vec3& p) {
  const auto& [a, b, c] = triangle.corners;
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 ap = p - a;
  const double d1 = dot(ab, ap);
  const double d2 = dot(ac, ap);
  if (d1 <= 0.0 && d2 <= 0.0) {
    return {a, 4};
  }
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp);
  const double d4 = dot(ac, bp);
  if (d3 >= 0.0 && d4 <= d3) {
    return {b, 5};
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
    return {a + ab * (d1 / (d1 - d3)), 1};
  }
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp);
  const double d6 = dot(ac, cp);
  if (d6 >= 0.0 && d5 <= d6) {
    return {c, 6};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
    return {a + ac * (d2 / (d2 - d6)), 3};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
    return {b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), 2};
  }
  const double whole = 1.0 / (va + vb + vc);
  return {a + ab * (vb * whole) + ac * (vc * whole), 0};
}

SurfacePoint nearestOn(const Sphere& sphere, const Vec3& p) {
  return nearestOnBall(sphere.centre, sphere.radius, p, {0.0, 1.0, 0.0});
}

SurfacePoint nearestOn(const Capsule& capsule, const Vec3& p) {
  return nearestOnBall(nearestOnSegment(capsule.a, capsule.b, p), capsule.radius, p, acrossOf(capsule.b - capsule.a));
}

SurfacePoint nearestOn(const Bounds& box, const Vec3& p) {
  const Vec3 nearest = clampedTo(box, p);
  const Vec3 way = p - nearest;
  const double distance = core::length(way);
  if (distance > 0.0) {
    return {distance, nearest, way * (1.0 / distance)};
  }
  // inside: the nearest of the six faces
  const std::array<double, 6> depths{p.x - box.low.x,  box.high.x - p.x, p.y - box.low.y,
                                     box.high.y - p.y, p.z - box.low.z,  box.high.z - p.z};
  const std::array<Vec3, 6> normals{{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};
  const auto face = static_cast<std::size_t>(std::min_element(depths.begin(), depths.end()) - depths.begin());
  return {-depths[face], p + normals[face] * depths[face], normals[face]};
}

SurfacePoint nearestOn(const HalfSpace& space, const Vec3& p) {
  const double distance = dot(p - space.point, space.normal);
  return {distance, p - space.normal * distance, space.normal};
}

double segmentDistance(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Ericson, section 5.1.9: the nearest points of the lines, then of the segments
  const Vec3 u = b - a;
  const Vec3 v = d - c;
  const Vec3 w = a - c;
  const double uu = dot(u, u);
  const double vv = dot(v, v);
  const double uv = dot(u, v);
  const double uw = dot(u, w);
  const double vw = dot(v, w);
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 0.0 ? std::clamp((uv * vw - uw * vv) / determinant, 0.0, 1.0) : 0.0;
  double t = vv > 0.0 ? (uv * s + vw) / vv : 0.0;
  if (t < 0.0 || t > 1.0 || !(vv > 0.0)) {
    t = std::clamp(t, 0.0, 1.0);
    s = uu > 0.0 ? std::clamp((uv * t - uw) / uu, 0.0, 1.0) : 0.0;
  }
  return core::length((a + u * s) - (c + v * t));
}

double distanceTo(const Sphere& sphere, const Vec3& a, const Vec3& b) {
  return core::length(nearestOnSegment(a, b, sphere.centre) - sphere.centre) - sphere.radius;
}

double distanceTo(const Capsule& capsule, const Vec3& a, const Vec3& b) {
  return segmentDistance(a, b, capsule.a, capsule.b) - capsule.radius;
}

double distanceTo(const Bounds& box, const Vec3& a, const Vec3& b) {
  // the squared distance from a box is convex along the segment: bisect its slope
  const Vec3 way = b - a;
  const auto slopeAt = [&](double t) {
    const Vec3 p = a + way * t;
    return dot(p - clampedTo(box, p), way);
  };
  double low = 0.0;
  double high = 1.0;
  if (slopeAt(0.0) < 0.0) {
    for (int i = 0; i < 60; ++i) {
      const double middle = (low + high) / 2.0;
      (slopeAt(middle) < 0.0 ? low : high) = middle;
    }
  } else {
    high = 0.0;
  }
  const Vec3 p = a + way * high;
  return core::length(p - clampedTo(box, p));
}

double distanceTo(const HalfSpace& space, const Vec3& a, const Vec3& b) {
  return std::min(dot(a - space.point, space.normal), dot(b - space.point, space.normal));
}

double distanceTo(const Triangle& triangle, const Vec3& a, const Vec3& b) {
  const Vec3 way = b - a;
  const double length = core::length(way);
  if (length > 0.0) {
    const auto hit = rayTo(triangle, a, way * (1.0 / length));
    if (hit && *hit <= length) {
      return 0.0;
    }
  }
  // the sides against the segment, and its ends against the triangle
  double distance = std::min(core::length(nearestOnTriangle(triangle, a).point - a),
                             core::length(nearestOnTriangle(triangle, b).point - b));
  for (std::size_t side = 0; side < 3; ++side) {
    distance = std::min(distance, segmentDistance(a, b, triangle.corners[side], triangle.corners[(side + 1) % 3]));
  }
  return distance;
}

std::optional<double> rayTo(const Sphere& sphere, const Vec3& origin, const Vec3& direction) {
  const Vec3 between = sphere.centre - origin;
  const double ahead = dot(between, direction);
  const double squared = dot(between, between) - ahead * ahead;
  const double half2 = sphere.radius * sphere.radius - squared;
  if (half2 < 0.0 || ahead + std::sqrt(half2) < 0.0) {
    return std::nullopt;
  }
  return std::max(ahead - std::sqrt(half2), 0.0);
}

std::optional<double> rayTo(const Capsule& capsule, const Vec3& origin, const Vec3& direction) {
  const Vec3 axis = capsule.b - capsule.a;
  const double length = core::length(axis);
  auto hit = rayTo(Sphere{capsule.a, capsule.radius}, origin, direction);
  const auto other = rayTo(Sphere{capsule.b, capsule.radius}, origin, direction);
  if (other && (!hit || *other < *hit)) {
    hit = other;
  }
  if (!(length > 0.0)) {
    return hit;
  }
  // the cylinder between the balls, across its axis
  const Vec3 unit = axis * (1.0 / length);
  const Vec3 from = origin - capsule.a;
  const Vec3 m = from - unit * dot(from, unit);
  const Vec3 n = direction - unit * dot(direction, unit);
  const double nn = dot(n, n);
  const double mn = dot(m, n);
  const double mm = dot(m, m) - capsule.radius * capsule.radius;
  const auto isBetween = [&](double t) {
    const double along = dot(from + direction * t, unit);
    return along >= 0.0 && along <= length;
  };
  if (mm <= 0.0 && isBetween(0.0)) {
    return 0.0;
  }
  const double root2 = mn * mn - nn * mm;
  if (nn > 0.0 && root2 >= 0.0) {
    const double t = (-mn - std::sqrt(root2)) / nn;
    if (t >= 0.0 && isBetween(t) && (!hit || t < *hit)) {
      hit = t;
    }
  }
  return hit;
}

std::optional<double> rayTo(const Bounds& box, const Vec3& origin, const Vec3& direction) {
  const std::array<double, 3> start{origin.x, origin.y, origin.z};
  const std::array<double, 3> way{direction.x, direction.y, direction.z};
  const std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  const std::array<double, 3> high{box.high.x, box.high.y, box.high.z};
  double from = 0.0;
  double to = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (way[axis] == 0.0) {
      if (start[axis] < low[axis] || start[axis] > high[axis]) {
        return std::nullopt;
      }
      continue;
    }
    const double a = (low[axis] - start[axis]) / way[axis];
    const double b = (high[axis] - start[axis]) / way[axis];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to ? std::optional(from) : std::nullopt;
}

std::optional<double> rayTo(const HalfSpace& space, const Vec3& origin, const Vec3& direction) {
  const double distance = dot(origin - space.point, space.normal);
  const double falling = -dot(direction, space.normal);
  if (distance <= 0.0) {
    return 0.0;
  }
  return falling > 0.0 ? std::optional(distance / falling) : std::nullopt;
}

std::optional<double> rayTo(const Triangle& triangle, const Vec3& origin, const Vec3& direction) {
  // Möller & Trumbore, Journal of Graphics Tools 2, 1997; both sides are met
  const auto& [a, b, c] = triangle.corners;
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 h = cross(direction, ac);
  const double determinant = dot(ab, h);
  if (determinant == 0.0) {
    return std::nullopt;
  }
  const Vec3 s = origin - a;
  const double u = dot(s, h) / determinant;
  const Vec3 q = cross(s, ab);
  const double v = dot(direction, q) / determinant;
  const double t = dot(ac, q) / determinant;
  const bool isHit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0;
  return isHit ? std::optional(t) : std::nullopt;
}

}  // namespace espalier::environment
