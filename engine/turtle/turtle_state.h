#pragma once

#include <array>
#include <cstdint>

#include "engine/core/frame.h"
#include "engine/core/vec3.h"

namespace espalier::turtle {

/// Most movements (tropisms and torques) that a view file can have: the language's bound.
inline constexpr std::size_t kMaximumMovements = 10;

/// Sentinel of TurtleState::segment, record and cylinder: there is none.
inline constexpr std::uint32_t kNoParent = 0xFFFFFFFF;

/// Position, orientation and attributes of the turtle. Pushed and popped as a whole by brackets, hence of fixed size.
struct TurtleState {
  core::Vec3 position;
  core::Frame frame;
  core::Frame otherFrame;                     // a second orientation, that @X exchanges with the first
  core::Vec3 previousHeading{0.0, 1.0, 0.0};  // of the last drawn segment: twist-free transport starts here
  core::Vec3 previousUp{0.0, 0.0, -1.0};
  double width = 1.0;
  double scale = 1.0;
  double angleFactor = 1.0;  // of turns without a parameter (@A)
  std::int32_t colour = 128;
  std::int32_t backColour = 128;
  std::int32_t contour = 0;  // current contour id; 0: circle
  std::int32_t contourSides = 8;
  std::int32_t texture = 0;
  double oldElasticity = 0.0;                          // of the old tropism
  std::array<double, kMaximumMovements> elasticity{};  // by movement id - 1
  double startTangent = 1.2;                           // length factors of a Hermite cylinder's tangents (@Gt)
  double endTangent = 1.2;
  bool hasSmoothRadius = false;     // the radius of a Hermite cylinder is a Hermite curve too (@Gr)
  double startRadiusTangent = 0.0;  // its slopes: change of the radius per distance of the control points
  double endRadiusTangent = 0.0;
  std::uint32_t branchOrder = 0;       // open brackets
  std::uint32_t segment = kNoParent;   // last drawn segment of this axis: parent of the next
  std::uint32_t record = kNoParent;    // last turtle record of this axis: parent of the next
  std::uint32_t cylinder = kNoParent;  // open @Gs cylinder, an index into Scene::cylinders
  std::uint32_t cylinderOrder = 0;     // branchOrder where it was opened
};

}  // namespace espalier::turtle
