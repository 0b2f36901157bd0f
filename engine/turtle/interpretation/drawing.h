#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// Draws for one turtle into a Scene; without a scene every function does nothing. Polygons and `{(t)` cylinders may be
/// nested and may end in another branch than they begin in, so they have their own stack. A `@Gs` cylinder belongs to
/// its axis and is a part of the turtle's state.
class Drawing {
 public:
  /// `view` must outlive the object; so must `scene`, which may be null.
  Drawing(Scene* scene, const files::ViewSettings& view, std::uint32_t plant);

  /// The module that is being interpreted: the elements that it draws belong to it.
  void setModule(std::uint64_t module) { module_ = module; }

  /// A polygon or cylinder has begun and not ended.
  [[nodiscard]] bool hasOpenShape() const { return !open_.empty(); }

  /// F, G: a line from `start` to the present position, unless a generalized cylinder is being drawn in its place.
  void line(TurtleState& state, const core::Vec3& start);
  /// A vertex or control point at the present position; `stripCount` 0: the current one.
  void vertex(const TurtleState& state, std::int32_t stripCount = 0);

  void beginPolygon(const TurtleState& state);
  /// `{(type, strips)`: 1 open, 2 closed Hermite; 3 open, 4 closed B-spline.
  void beginCylinder(const TurtleState& state, std::int32_t type, std::int32_t stripCount);
  void endPolygon();

  void startAxisCylinder(TurtleState& state);
  void addAxisCylinderPoint(const TurtleState& state, std::int32_t stripCount);
  void endAxisCylinder(TurtleState& state, std::int32_t stripCount);

  void ball(const TurtleState& state, Ball::Kind kind, double diameter);
  void surface(const TurtleState& state, std::uint32_t index, bool isTriangleSurface, const core::Vec3& scale);
  void label(const TurtleState& state, std::string text);

  void startPatch(std::int32_t id);
  void setPatchPoint(const TurtleState& state, std::int32_t id, std::int32_t row, std::int32_t column);
  void drawPatch(const TurtleState& state, std::int32_t id, std::int32_t subdivisionS, std::int32_t subdivisionT);

  /// Drops unfinished polygons and cylinders of fewer than two points.
  void finish();

 private:
  struct OpenShape {
    bool isCylinder = false;
    std::int32_t stripCount = 4;
    Polygon polygon;
    GeneralizedCylinder cylinder;
  };
  struct OpenPatch {
    std::array<core::Vec3, 25> points;  // rows and columns 0 to 4
    bool isZeroBased = false;           // row or column 0 was used
  };

  /// A texture of the view file, or 0 when there is none of that number.
  [[nodiscard]] std::int32_t textureOf(std::int32_t id) const;
  [[nodiscard]] CylinderPoint pointOf(const TurtleState& state, std::int32_t stripCount) const;

  Scene* scene_;
  const files::ViewSettings* view_;
  std::uint32_t plant_;
  std::uint64_t module_ = 0;
  std::vector<OpenShape> open_;  // innermost last
  std::unordered_map<std::int32_t, OpenPatch> patches_;
};

/// Formats a label with numbers by C's conversions (d i u o x X c e E f F g G and %%); a conversion without a number
/// left prints nothing.
[[nodiscard]] std::string formatLabel(std::string_view format, std::span<const double> numbers);

}  // namespace espalier::turtle
