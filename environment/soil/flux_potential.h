#pragma once

#include <cstddef>
#include <vector>

#include "environment/soil/soil_layer.h"

namespace espalier::environment {

/// The matric flux potential Φ(h) = ∫ K dh from the driest soil to a head h, length²/day, of one soil. Flow between two
/// heads without gravity is the difference of their potentials over the distance, however dry the soil (Gardner 1958).
/// A table in ln(−h), with cubic polynomials that have the exact K at its nodes; relative error below 10⁻⁷.
class FluxPotential {
 public:
  explicit FluxPotential(const SoilLayer& soil);

  [[nodiscard]] double at(double head) const;
  /// K at a head, length/day.
  [[nodiscard]] double conductivityAt(double head) const { return soil_.conductivityAt(head); }
  /// The head of a potential; the driest head of the table below its first value.
  [[nodiscard]] double headAt(double potential) const;

  /// A head with what a mean of K needs of it.
  struct Point {
    double head = 0.0;
    double conductivity = 0.0;       // length/day
    double conductivitySlope = 0.0;  // 1/day
    double phi = 0.0;                // Φ, length²/day
    double missing = 0.0;            // Φ(0) − Φ, length²/day
  };
  [[nodiscard]] Point pointAt(double head) const {
    return pointAt(head, soil_.conductivityAt(head), soil_.conductivitySlope(head));
  }
  /// The same with K and its slope, when they are known.
  [[nodiscard]] Point pointAt(double head, double conductivity, double conductivitySlope) const {
    return {head, conductivity, conductivitySlope, at(head), missingAt(head)};
  }

  /// A mean of K between two heads, and its derivatives by them.
  struct Mean {
    double conductivity = 0.0;  // length/day
    double byA = 0.0;           // 1/day
    double byB = 0.0;
  };
  /// (Φ(a) − Φ(b))/(a − b); where both heads agree, (K(a) + K(b))/2.
  [[nodiscard]] Mean meanBetween(const Point& a, const Point& b) const;
  [[nodiscard]] Mean meanBetween(double a, double b) const { return meanBetween(pointAt(a), pointAt(b)); }

 private:
  [[nodiscard]] double interpolate(const std::vector<double>& table, double head) const;
  [[nodiscard]] double missingAt(double head) const;

  SoilLayer soil_;
  double firstLog_ = 0.0;        // ln(−h) of the first node, the wettest
  std::vector<double> phi_;      // Φ at the nodes, exact in dry soil
  std::vector<double> missing_;  // Φ(0) − Φ at the nodes, exact in wet soil
  std::vector<double> slope_;    // −dΦ/d ln(−h) there
};

}  // namespace espalier::environment
