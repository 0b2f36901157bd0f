#include "engine/turtle/export/picture/raster_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

PictureBounds boundsOfBox(const files::Box& box, const Projection& projection) {
  PictureBounds bounds;
  for (const double x : {box.minimum.x, box.maximum.x}) {
    for (const double y : {box.minimum.y, box.maximum.y}) {
      for (const double z : {box.minimum.z, box.maximum.z}) {
        bounds.include(projection.project({x, y, z}), 0.0);
      }
    }
  }
  return bounds;
}

}  // namespace

RasterCamera::RasterCamera(const Projection& projection, const files::ViewSettings& view, const PictureBounds& drawn,
                           const PictureOptions& options)
    : projection_(projection) {
  const double width = options.widthPixels;
  const double height = options.heightPixels;
  const bool isFitted = options.framing == PictureFraming::Fitted;
  if (!isFitted && projection.isPerspective()) {
    // the viewing angle spans the height; the reference point is in the middle
    const double half = std::clamp(view.viewingAngleDegrees, 0.1, 179.0) / 2.0 * std::numbers::pi / 180.0;
    scale_ = height / 2.0 / (core::tan(half) * projection.distance());
    offsetX_ = width / 2.0;
    offsetY_ = height / 2.0;
    return;
  }
  const PictureBounds bounds = !isFitted && view.box ? boundsOfBox(*view.box, projection) : drawn;
  const double margin = isFitted ? options.marginFraction : 0.0;
  const double spanX = bounds.empty() ? 0.0 : bounds.right - bounds.left;
  const double spanY = bounds.empty() ? 0.0 : bounds.top - bounds.bottom;
  const double scaleX = spanX > 0.0 ? width * (1.0 - 2.0 * margin) / spanX : std::numeric_limits<double>::infinity();
  const double scaleY = spanY > 0.0 ? height * (1.0 - 2.0 * margin) / spanY : std::numeric_limits<double>::infinity();
  scale_ = std::isfinite(std::min(scaleX, scaleY)) ? std::min(scaleX, scaleY) : 1.0;
  scale_ *= isFitted ? 1.0 : view.scaleFactor;
  if (!bounds.empty()) {
    offsetX_ = width / 2.0 - scale_ * (bounds.left + bounds.right) / 2.0;
    offsetY_ = height / 2.0 + scale_ * (bounds.bottom + bounds.top) / 2.0;
  }
}

PagePoint RasterCamera::onPage(const Vec3& point) const {
  const ProjectedPoint p = projection_.project(point);
  return {.x = offsetX_ + p.x * scale_,
          .y = offsetY_ - p.y * scale_,
          .nearness = projection_.isPerspective() ? 1.0 / p.depth : -p.depth,
          .pixelsPerUnit = scale_ * p.magnification,
          .depth = p.depth};
}

Vec3 RasterCamera::fromPage(double x, double y, double depth) const {
  return projection_.unproject((x - offsetX_) / scale_, (offsetY_ - y) / scale_, depth);
}

}  // namespace espalier::turtle
