#include "engine/turtle/export/picture/picture_bounds.h"

#include <algorithm>

namespace espalier::turtle {

void PictureBounds::include(const ProjectedPoint& point, double radius) {
  left = std::min(left, point.x - radius);
  right = std::max(right, point.x + radius);
  bottom = std::min(bottom, point.y - radius);
  top = std::max(top, point.y + radius);
  nearest = std::min(nearest, point.depth);
  farthest = std::max(farthest, point.depth);
}

void PictureBounds::include(const PictureBounds& other) {
  left = std::min(left, other.left);
  right = std::max(right, other.right);
  bottom = std::min(bottom, other.bottom);
  top = std::max(top, other.top);
  nearest = std::min(nearest, other.nearest);
  farthest = std::max(farthest, other.farthest);
}

void PictureFrame::include(const PictureFrame& other) {
  bounds.include(other.bounds);
  isParallel = isParallel || other.isParallel;
}

}  // namespace espalier::turtle
