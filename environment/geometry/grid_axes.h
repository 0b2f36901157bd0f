#pragma once

#include <array>
#include <optional>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// The three directions of a grid along the axes: which world direction is up, and how world coordinates map to grid
/// coordinates, whose y is up, and back.
struct GridAxes {
  int up = 1;         // index of the world axis along which the grid's y runs
  double sign = 1.0;  // -1: up is the negative axis

  [[nodiscard]] constexpr core::Vec3 toGrid(const core::Vec3& p) const {
    if (up == 0) {
      return {p.y, sign * p.x, p.z};
    }
    return up == 1 ? core::Vec3{p.x, sign * p.y, p.z} : core::Vec3{p.x, sign * p.z, p.y};
  }
  [[nodiscard]] constexpr core::Vec3 toWorld(const core::Vec3& p) const {
    if (up == 0) {
      return {sign * p.y, p.x, p.z};
    }
    return up == 1 ? core::Vec3{p.x, sign * p.y, p.z} : core::Vec3{p.x, p.z, sign * p.y};
  }
};

/// The axes of a world whose up is along x, y or z; nothing otherwise.
[[nodiscard]] constexpr std::optional<GridAxes> axesOf(const core::Vec3& up) {
  const std::array<double, 3> components{up.x, up.y, up.z};
  std::optional<GridAxes> axes;
  for (int axis = 0; axis < 3; ++axis) {
    const double component = components[static_cast<std::size_t>(axis)];
    if (component != 0.0) {
      if (axes) {
        return std::nullopt;
      }
      axes = GridAxes{axis, component > 0.0 ? 1.0 : -1.0};
    }
  }
  return axes;
}

}  // namespace espalier::environment
