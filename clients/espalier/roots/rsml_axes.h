#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/roots/rsml_functions.h"
#include "engine/core/vec3.h"

namespace espalier::roots {

/// A `root` element of the Root System Markup Language as it is read. Laterals are inside of it, after its geometry or
/// before.
struct RsmlAxis {
  std::size_t line = 0;  // of the file
  std::string id, label;
  std::uint32_t plant = 0;  // of the file
  std::vector<core::Vec3> points;
  std::vector<double> diameters, emergences;  // (points), or empty; not a number: the file gives none
  std::vector<RsmlFunction> functions;        // that are known by their names and have samples
  std::optional<double> parentNode;
  std::size_t parent = std::string::npos;  // index of the axis that it is inside of
  std::uint32_t order = 1;
};

/// The tree of points of all axes: a lateral begins at the point `parentNode` of its parent, or else at the nearest
/// one. Axes without points are left out. The remark names what the file does not say as it should. Parents come before
/// their laterals. The error is a sentence: laterals and their parents are too many to look for the nearest points.
[[nodiscard]] tl::expected<RootSystem, std::string> joinAxes(std::vector<RsmlAxis> axes, const std::string& unit);

}  // namespace espalier::roots
