#pragma once

#include <cmath>

#include "engine/core/vec3.h"
#include "environment/base/float_number.h"

namespace espalier::environment {

/// A vector of 32-bit floats, with which the published environment programs compute. Every operation rounds, and sums
/// go from left to right, so that a comparison falls as theirs do.
struct FloatVec {
  float x = 0.0F;
  float y = 0.0F;
  float z = 0.0F;
};

[[nodiscard]] inline FloatVec toFloat(const core::Vec3& v) {
  return {toFloat(v.x), toFloat(v.y), toFloat(v.z)};
}
[[nodiscard]] inline core::Vec3 toDouble(const FloatVec& v) {
  return {v.x, v.y, v.z};
}
[[nodiscard]] inline FloatVec operator+(const FloatVec& a, const FloatVec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[nodiscard]] inline FloatVec operator-(const FloatVec& a, const FloatVec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[nodiscard]] inline FloatVec operator*(const FloatVec& v, float factor) {
  return {v.x * factor, v.y * factor, v.z * factor};
}
[[nodiscard]] inline float dot(const FloatVec& a, const FloatVec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// Functions of the mathematics library run in double precision, and their result is rounded.
[[nodiscard]] inline float length(const FloatVec& v) {
  return static_cast<float>(std::sqrt(static_cast<double>(dot(v, v))));
}
/// A vector without length stays as it is.
[[nodiscard]] inline FloatVec normalised(const FloatVec& v) {
  const float size = length(v);
  return size > 0.0F ? FloatVec{v.x / size, v.y / size, v.z / size} : v;
}

}  // namespace espalier::environment
