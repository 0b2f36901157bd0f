#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/frame.h"
#include "engine/core/vec3.h"

namespace espalier::turtle {

/// Position, orientation and attributes of the turtle. Pushed and popped as a whole by brackets.
struct TurtleState {
  core::Vec3 position;
  core::Frame frame;
  core::Vec3 previousHeading{0.0, 1.0, 0.0};  // of the last drawn segment: twist-free transport starts here
  core::Vec3 previousUp{0.0, 0.0, -1.0};
  double width = 1.0;
  double scale = 1.0;
  std::int32_t colour = 128;
  std::int32_t backColour = 128;
  std::int32_t contour = 0;         // current contour id; 0: circle
  std::int32_t contourSides = 8;
  std::int32_t texture = 0;
  double oldElasticity = 0.0;       // of the old tropism
  std::vector<double> elasticity;   // by movement id - 1
  std::uint32_t branchOrder = 0;    // open brackets
};

}  // namespace espalier::turtle
