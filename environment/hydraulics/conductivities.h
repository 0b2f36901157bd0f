#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "environment/base/configuration.h"

namespace espalier::environment {

/// Axial conductance of so many vessels of a radius in metres, by Hagen (1839) and Poiseuille (1846): N π r⁴ ρg/8μ with
/// water at 20 °C (998.2 kg/m³, 1.0016 mPa s), in m³/day for a fall of the head of 1 along a length of 1.
[[nodiscard]] double vesselConductance(double count, double radius);

/// A conductivity of roots by order and age: rows of order, age in days and value.
class ConductivityTable {
 public:
  ConductivityTable() = default;
  /// `rows` are sorted by order and then by age; without rows the value is `constant` everywhere.
  ConductivityTable(double constant, const ConfigurationRows& rows);

  /// Linear between the ages of the rows, constant beyond. An order without rows has those of the highest order below
  /// it, or else of the lowest order.
  [[nodiscard]] double at(double order, double age) const;

  /// The problem of rows, as the end of a sentence about the key; empty when there is none.
  [[nodiscard]] static std::string problemOf(const ConfigurationRows& rows);

 private:
  double constant_ = 0.0;
  ConfigurationRows rows_;
};

}  // namespace espalier::environment
