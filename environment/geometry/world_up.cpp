#include "environment/geometry/world_up.h"

#include <string>

namespace espalier::environment {

tl::expected<core::Vec3, turtle::EnvironmentError> upOf(std::string_view process, const turtle::World& world) {
  if (core::length(world.up) > 0.0) {
    return core::normalised(world.up);
  }
  return tl::unexpected(turtle::EnvironmentError{"Environment '" + std::string(process) +
                                                     "' needs the world's vector 'up', which has length 0. Set it to "
                                                     "0 1 0.",
                                                 false});
}

tl::expected<GridAxes, turtle::EnvironmentError> gridAxesOf(std::string_view process, const turtle::World& world) {
  if (const auto axes = axesOf(world.up)) {
    return *axes;
  }
  return tl::unexpected(turtle::EnvironmentError{
      "Environment '" + std::string(process) + "' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.",
      false});
}

}  // namespace espalier::environment
