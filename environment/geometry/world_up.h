#pragma once

#include <string_view>
#include <tl/expected.hpp>

#include "engine/core/vec3.h"
#include "engine/turtle/environment_process.h"
#include "environment/geometry/grid_axes.h"

namespace espalier::environment {

/// The unit vector of the world's `up`, or the error of the process when `up` has length 0.
[[nodiscard]] tl::expected<core::Vec3, turtle::EnvironmentError> upOf(std::string_view process,
                                                                      const turtle::World& world);

/// The axes of a grid whose layers lie across the world's `up`, or the error of the process when `up` is not along x, y
/// or z.
[[nodiscard]] tl::expected<GridAxes, turtle::EnvironmentError> gridAxesOf(std::string_view process,
                                                                          const turtle::World& world);

}  // namespace espalier::environment
