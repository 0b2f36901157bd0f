#pragma once

#include <limits>

#include "engine/turtle/export/picture/projection.h"

namespace espalier::turtle {

/// A rectangle of the picture plane and the depths that lie in it.
struct PictureBounds {
  double left = std::numeric_limits<double>::infinity();
  double right = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -std::numeric_limits<double>::infinity();

  [[nodiscard]] bool empty() const { return !(left <= right); }
  void include(const ProjectedPoint& point, double radius);
  void include(const PictureBounds& other);
};

/// The extent that fitted pictures show: everything drawn in one scene, or in all frames of an animation, so that they
/// have one scale and do not jump.
struct PictureFrame {
  PictureBounds bounds;
  bool isParallel = false;  // a perspective's viewer would stand inside some scene

  void include(const PictureFrame& other);
};

}  // namespace espalier::turtle
