#pragma once

#include <array>
#include <cmath>

namespace espalier::core {

/// A vector of three doubles: a position in the world's length unit, or a direction.
struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator-(const Vec3& a) {
  return {-a.x, -a.y, -a.z};
}
constexpr Vec3 operator*(const Vec3& a, double s) {
  return {a.x * s, a.y * s, a.z * s};
}
constexpr Vec3 operator*(double s, const Vec3& a) {
  return a * s;
}

[[nodiscard]] inline bool isFinite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// x, y or z for the axes 0, 1 and 2.
[[nodiscard]] constexpr double component(const Vec3& v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// x, y, z, for loops over axes.
[[nodiscard]] constexpr std::array<double, 3> componentsOf(const Vec3& v) {
  return {v.x, v.y, v.z};
}

[[nodiscard]] constexpr double dot(const Vec3& a, const Vec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Right-handed cross product.
[[nodiscard]] constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

[[nodiscard]] inline double length(const Vec3& a) {
  return std::sqrt(dot(a, a));
}

/// The unit vector along a; a itself when its length is 0.
[[nodiscard]] inline Vec3 normalised(const Vec3& a) {
  const double l = length(a);
  return l > 0.0 ? Vec3{a.x / l, a.y / l, a.z / l} : a;
}

}  // namespace espalier::core
