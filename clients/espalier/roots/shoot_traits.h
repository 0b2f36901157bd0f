#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "engine/turtle/scene/geometry.h"

namespace espalier::roots {

/// Leaves and crown of shoots. Leaves are the polygons, surfaces and patches of the plants; balls and generalized
/// cylinders are none.
struct ShootTraits {
  static constexpr std::size_t kClasses = 9;  // of 10 degrees
  std::uint64_t leafCount = 0;
  double leafArea = 0.0;     // one side
  double inclination = 0.0;  // mean over the leaf area of the angle between leaf and ground, degrees
  /// Parts of the leaf area by that angle: 0 to 10 degrees, 10 to 20, … (kClasses).
  std::array<double, kClasses> inclinations{};
  double base = 0.0;                    // of the lowest point of a leaf, above the lowest point of the plants
  double top = 0.0;                     // of the highest point of a leaf
  std::array<double, 2> crownWidths{};  // sides of the box around the leaves, along the two horizontal axes
  double crownArea = 0.0;               // of the convex hull of the leaves, seen from above
  double leafAreaIndex = 0.0;           // leaf area over `ground`, or over the crown area
};

/// `up` is the index of the axis that is up. `ground` is the area of the ground of the plants; 0: the crown area.
/// O(n log n).
[[nodiscard]] ShootTraits shootTraitsOf(const turtle::Geometry& geometry, int up, double ground);

/// Rows of a table as traitTable() has them. The column `order` has the middle of a class of angles, or the axis of a
/// width. `unit` is that of lengths. Empty without leaves.
[[nodiscard]] std::string shootTraitRows(const ShootTraits& traits, int up, const std::string& unit);

}  // namespace espalier::roots
