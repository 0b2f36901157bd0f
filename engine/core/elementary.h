#pragma once

#include <cmath>

#include "engine/core/identifiers.h"

extern "C" {
double espalier_musl_acos(double);
double espalier_musl_asin(double);
double espalier_musl_atan(double);
double espalier_musl_cos(double);
double espalier_musl_exp(double);
double espalier_musl_exp2(double);
double espalier_musl_expm1(double);
double espalier_musl_log(double);
double espalier_musl_log10(double);
double espalier_musl_log1p(double);
double espalier_musl_log2(double);
double espalier_musl_pow(double, double);
double espalier_musl_sin(double);
double espalier_musl_tan(double);
}

namespace espalier::core {

/// The elementary functions of Espalier: the same bits on every processor, with every compiler and at every level of
/// optimisation. Each is within 1 ulp of the exact value. They are musl's (engine/core/musl), without fused
/// multiply-add. The C library's functions of these names choose other code for other processors. Functions that are
/// exact by IEEE 754 (sqrt, floor, fmod and so on) stay std::.
[[nodiscard]] inline double acos(double x) {
  return espalier_musl_acos(x);
}
[[nodiscard]] inline double asin(double x) {
  return espalier_musl_asin(x);
}
[[nodiscard]] inline double atan(double x) {
  return espalier_musl_atan(x);
}
/// musl's is up to 1.4 ulp off. This one applies FDLIBM's reductions to y and x, not to their quotient.
[[nodiscard]] double atan2(double y, double x);
[[nodiscard]] inline double cos(double x) {
  return espalier_musl_cos(x);
}
[[nodiscard]] inline double exp(double x) {
  return espalier_musl_exp(x);
}
[[nodiscard]] inline double exp2(double x) {
  return espalier_musl_exp2(x);
}
[[nodiscard]] inline double expm1(double x) {
  return espalier_musl_expm1(x);
}
/// Not musl's, which is up to 1.01 ulp off: the root with a correction (Borges, An improved algorithm for hypot(a,b),
/// 2019, without fused multiply-add).
[[nodiscard]] double hypot(double x, double y);
[[nodiscard]] inline double log(double x) {
  return espalier_musl_log(x);
}
[[nodiscard]] inline double log10(double x) {
  return espalier_musl_log10(x);
}
[[nodiscard]] inline double log1p(double x) {
  return espalier_musl_log1p(x);
}
[[nodiscard]] inline double log2(double x) {
  return espalier_musl_log2(x);
}
[[nodiscard]] inline double pow(double x, double y) {
  return espalier_musl_pow(x, y);
}
[[nodiscard]] inline double sin(double x) {
  return espalier_musl_sin(x);
}
[[nodiscard]] inline double tan(double x) {
  return espalier_musl_tan(x);
}

/// The elementary functions of a mode: those above in Espalier's own mode, the C library's in the compatible modes,
/// because the runs that these reproduce were computed with it.
class Elementary {
 public:
  constexpr Elementary() = default;
  constexpr explicit Elementary(Compatibility mode) : usesCLibrary_(mode != Compatibility::Espalier) {}

  [[nodiscard]] double acos(double x) const { return usesCLibrary_ ? std::acos(x) : core::acos(x); }
  [[nodiscard]] double asin(double x) const { return usesCLibrary_ ? std::asin(x) : core::asin(x); }
  [[nodiscard]] double atan(double x) const { return usesCLibrary_ ? std::atan(x) : core::atan(x); }
  [[nodiscard]] double atan2(double y, double x) const { return usesCLibrary_ ? std::atan2(y, x) : core::atan2(y, x); }
  [[nodiscard]] double cos(double x) const { return usesCLibrary_ ? std::cos(x) : core::cos(x); }
  [[nodiscard]] double exp(double x) const { return usesCLibrary_ ? std::exp(x) : core::exp(x); }
  [[nodiscard]] double hypot(double x, double y) const { return usesCLibrary_ ? std::hypot(x, y) : core::hypot(x, y); }
  [[nodiscard]] double log(double x) const { return usesCLibrary_ ? std::log(x) : core::log(x); }
  [[nodiscard]] double pow(double x, double y) const { return usesCLibrary_ ? std::pow(x, y) : core::pow(x, y); }
  [[nodiscard]] double sin(double x) const { return usesCLibrary_ ? std::sin(x) : core::sin(x); }
  [[nodiscard]] double tan(double x) const { return usesCLibrary_ ? std::tan(x) : core::tan(x); }

 private:
  bool usesCLibrary_ = false;
};

}  // namespace espalier::core
