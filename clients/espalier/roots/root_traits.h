#pragma once

#include <map>
#include <string>

#include "clients/espalier/roots/root_system.h"

namespace espalier::roots {

/// Lengths, numbers and topology of roots.
struct RootTraits {
  struct Order {
    std::uint64_t number = 0;  // of axes
    double length = 0.0;
    double diameter = 0.0;  // mean over the length that has one; 0: none has
    double lengthWithDiameter = 0.0;
  };
  double length = 0.0;
  std::map<std::uint32_t, Order> orders;
  double height = 0.0;  // of the box around all points, along up
  double width = 0.0;   // the larger horizontal side of that box
  // topology (Fitter 1987): links end at branching points and tips
  std::uint64_t magnitude = 0;   // number of tips
  std::uint64_t altitude = 0;    // links on the longest way from a tip to its collar
  std::uint64_t pathLength = 0;  // sum of the links on the ways from all tips
};

/// `up` is the index of the axis that is up. A point with several laterals counts as as many branching points.
[[nodiscard]] RootTraits traitsOf(const RootSystem& roots, int up);

/// The unit of lengths in tables: that of a file or of the world; `length` when nothing says it.
[[nodiscard]] std::string unitOfLengths(const std::string& unit);

/// A table of traits: name, order (empty: all), value and unit, with a header, separated by tabs. `unit` is that of
/// lengths.
[[nodiscard]] std::string traitTable(const RootTraits& traits, const std::string& unit);

}  // namespace espalier::roots
