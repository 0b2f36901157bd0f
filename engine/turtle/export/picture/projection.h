#pragma once

#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"

namespace espalier::turtle {

/// A point of the picture plane, y upward, with its distance from the viewer.
struct ProjectedPoint {
  double x = 0.0;
  double y = 0.0;
  double depth = 0.0;
  double magnification = 1.0;  // picture units per world unit at this depth
};

/// The camera of the view settings: parallel or perspective, seen from the viewpoint toward the reference point with +y
/// up. Picture units are world units at the reference point; fitting them to a page is the caller's.
class Projection {
 public:
  explicit Projection(const files::ViewSettings& view);

  [[nodiscard]] ProjectedPoint project(const core::Vec3& point) const;
  /// The point of the world at a place of the picture plane and a depth: project() the other way round.
  [[nodiscard]] core::Vec3 unproject(double x, double y, double depth) const;
  /// Toward the viewer.
  [[nodiscard]] const core::Vec3& towardViewer() const { return back_; }
  /// Toward the viewer from a point, unit.
  [[nodiscard]] core::Vec3 towardViewer(const core::Vec3& point) const;
  [[nodiscard]] bool isPerspective() const { return isPerspective_; }
  /// From the viewer to the reference point.
  [[nodiscard]] double distance() const { return distance_; }
  [[nodiscard]] const core::Vec3& right() const { return right_; }
  [[nodiscard]] const core::Vec3& up() const { return up_; }
  /// Whether a point lies in front of a perspective viewer.
  [[nodiscard]] bool isVisible(const core::Vec3& point) const;
  void useParallel() { isPerspective_ = false; }

 private:
  core::Vec3 target_;
  core::Vec3 right_, up_, back_;
  double distance_ = 1.0;  // from viewer to target
  bool isPerspective_ = false;
};

}  // namespace espalier::turtle
