#pragma once

#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/picture/picture.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/export/picture/projection.h"

namespace espalier::turtle {

/// Where a point of the world is on the page.
struct PagePoint {
  double x = 0.0;              // pixels from the left edge
  double y = 0.0;              // pixels from the upper edge
  double nearness = 0.0;       // larger is nearer; linear on the page along a straight line
  double pixelsPerUnit = 1.0;  // at this depth
  double depth = 0.0;          // world units from the viewer
};

/// From the world to the page of a picture.
class RasterCamera {
 public:
  /// `bounds` is the extent of the drawing in the projection's picture units.
  RasterCamera(const Projection& projection, const files::ViewSettings& view, const PictureBounds& bounds,
               const PictureOptions& options);

  [[nodiscard]] PagePoint onPage(const core::Vec3& point) const;
  /// The point of the world at a place of the page and a depth: onPage() the other way round.
  [[nodiscard]] core::Vec3 fromPage(double x, double y, double depth) const;
  [[nodiscard]] const Projection& projection() const { return projection_; }
  /// Whether a point is in front of the viewer.
  [[nodiscard]] bool isVisible(const core::Vec3& point) const { return projection_.isVisible(point); }

 private:
  Projection projection_;
  double scale_ = 1.0;  // pixels per picture unit
  double offsetX_ = 0.0;
  double offsetY_ = 0.0;
};

}  // namespace espalier::turtle
