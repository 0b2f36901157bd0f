#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/buffer.h"
#include "engine/core/frame.h"
#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// A drawn line (F, G): a cylinder, strip or pixel line by the view file's line style.
struct Segment {
  core::Vec3 start, end;
  core::Frame frame;        // at the end
  double startWidth = 1.0;  // diameters, world units
  double endWidth = 1.0;
  std::int32_t colour = 128;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment this one continues or branches from
  std::int32_t texture = 0;          // of the view file, from 1; 0: none

  bool operator==(const Segment&) const = default;
};

/// A filled polygon `{...}`.
struct Polygon {
  std::vector<core::Vec3> vertices;
  std::int32_t colour = 128;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // of `{`
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it grows on

  bool operator==(const Polygon&) const = default;
};

/// A sphere or disc (@O, @o, @c).
struct Ball {
  enum class Kind : std::uint8_t { Sphere, ScreenDisc, Disc };
  Kind kind = Kind::Sphere;
  core::Vec3 centre;
  core::Frame frame;
  double diameter = 1.0;
  std::int32_t colour = 128;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it grows on

  bool operator==(const Ball&) const = default;
};

/// A predefined surface ~c placed by the turtle. The sampled mesh: row-major quads.
struct SurfaceInstance {
  std::uint32_t surface = 0;       // index into ViewSettings::surfaces
  bool isTriangleSurface = false;  // index into triangleSurfaces instead
  core::Vec3 position;
  core::Frame frame;
  core::Vec3 scale{1.0, 1.0, 1.0};  // along L, H, U, the turtle's scale included
  std::int32_t colour = 128;
  std::int32_t texture = 0;  // of the view file, from 1; 0: none
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it grows on

  bool operator==(const SurfaceInstance&) const = default;
};

/// A text label (@L).
struct Label {
  core::Vec3 position;
  std::string text;
  std::int32_t colour = 128;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it stands on

  bool operator==(const Label&) const = default;
};

/// One point of a generalized cylinder.
struct CylinderPoint {
  core::Vec3 position;
  core::Frame frame;
  double width = 1.0;
  std::int32_t colour = 128;  // of the stretch that ends here
  std::int32_t contour = 0;
  std::int32_t stripCount = 4;  // mesh strips of the stretch that ends here
  std::int32_t sideCount = 8;
  double startTangent = 1.2;        // length factor of the tangent at the start of the stretch that ends here (@Gt)
  double endTangent = 1.2;          // and at its end
  bool hasSmoothRadius = false;     // the radius is a Hermite curve over that stretch (@Gr), else it changes linearly
  double startRadiusTangent = 0.0;  // its slopes: change of the radius per distance of the control points; 0: level
  double endRadiusTangent = 0.0;

  bool operator==(const CylinderPoint&) const = default;
};

/// A generalized cylinder ({(t)...}(t) or @Gs ... @Ge).
struct GeneralizedCylinder {
  enum class Curve : std::uint8_t { Hermite, BSpline };
  Curve curve = Curve::Hermite;
  bool isClosed = false;
  std::int32_t texture = 0;  // of the view file, from 1; 0: none
  std::vector<CylinderPoint> points;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it grows on

  bool operator==(const GeneralizedCylinder&) const = default;
};

/// A 4x4 bicubic Bezier patch whose control points the turtle visited (@PS, @PC, @PD). World coordinates, row by row.
struct Patch {
  std::array<core::Vec3, 16> points;
  std::int32_t subdivisionS = 5;
  std::int32_t subdivisionT = 5;
  std::int32_t colour = 128;
  std::int32_t texture = 0;  // of the view file, from 1; 0: none
  std::uint32_t plant = 0;
  std::uint64_t module = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // the segment it grows on
};

/// Everything a turtle drew. Plain data in world units.
struct Scene {
  core::Buffer<Segment> segments;
  std::vector<Polygon> polygons;
  std::vector<Ball> balls;
  std::vector<SurfaceInstance> surfaces;
  std::vector<GeneralizedCylinder> cylinders;
  std::vector<Patch> patches;
  std::vector<Label> labels;
  files::LineStyle lineStyle = files::LineStyle::Pixel;

  void clear();
  [[nodiscard]] bool empty() const;
};

/// How much a scene held at some time.
struct SceneMark {
  SceneMark() = default;
  explicit SceneMark(const Scene& scene);
  [[nodiscard]] bool isEmpty() const;
  /// Takes back what the scene got since then.
  void restore(Scene& scene) const;

  std::size_t segments = 0, polygons = 0, balls = 0, surfaces = 0, cylinders = 0, patches = 0, labels = 0;
};

/// One entry of the turtle stream: the turtle's state after a module that moved it, drew something or is a
/// communication or query module. Of symbols that belong together (`?E(x)`, `@M(x,y)`, `~l(s)`) the last one is the
/// record's module.
struct TurtleRecord {
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::uint16_t symbol = 0;  // core::SymbolId of the string's module
  core::Vec3 position;
  core::Frame frame;
  double width = 1.0;
  std::int32_t colour = 128;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = kNoParent;  // index of the record this one grows from
  std::vector<double> parameters;
};

}  // namespace espalier::turtle
