#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::turtle {

/// A quantity in the cells of a box along the world's axes, as an environment holds or last computed it. For files and
/// pictures.
struct Field {
  std::string name;  // "waterContent"; of a member of several environments "soil.waterContent"
  std::string unit;
  std::array<std::size_t, 3> cells{1, 1, 1};  // along x, y, z
  core::Vec3 position;                        // corner with the smallest coordinates
  core::Vec3 cellSize{1.0, 1.0, 1.0};
  std::vector<double> values;  // by cell, x fastest, then y, then z

  bool operator==(const Field&) const = default;
};

}  // namespace espalier::turtle
