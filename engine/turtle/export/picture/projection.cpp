#include "engine/turtle/export/picture/projection.h"

#include <cmath>
#include <numbers>

#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

Projection::Projection(const files::ViewSettings& view)
    : target_(view.viewReferencePoint), isPerspective_(view.isPerspective) {
  Vec3 back = view.viewpoint - view.viewReferencePoint;
  if (core::length(back) == 0.0) {
    back = {0.0, 0.0, 1.0};
  }
  distance_ = core::length(back) / (view.scaleFactor > 0.0 ? view.scaleFactor : 1.0);
  back_ = core::normalised(back);
  // +y is up on the page; looking along it, -z is
  const Vec3 vertical = std::abs(back_.y) > 0.999999 ? Vec3{0.0, 0.0, back_.y > 0.0 ? -1.0 : 1.0} : Vec3{0.0, 1.0, 0.0};
  right_ = core::normalised(core::cross(vertical, back_));
  up_ = core::cross(back_, right_);
  const double twist = view.twistDegrees * std::numbers::pi / 180.0;
  right_ = rotatedAbout(right_, back_, twist);
  up_ = rotatedAbout(up_, back_, twist);
}

ProjectedPoint Projection::project(const Vec3& point) const {
  const Vec3 d = point - target_;
  const double depth = distance_ - core::dot(d, back_);
  const double magnification = isPerspective_ ? distance_ / depth : 1.0;
  return {core::dot(d, right_) * magnification, core::dot(d, up_) * magnification, depth, magnification};
}

Vec3 Projection::unproject(double x, double y, double depth) const {
  const double magnification = isPerspective_ ? depth / distance_ : 1.0;  // world units per picture unit
  return target_ + x * magnification * right_ + y * magnification * up_ + (distance_ - depth) * back_;
}

Vec3 Projection::towardViewer(const Vec3& point) const {
  return isPerspective_ ? core::normalised(target_ + distance_ * back_ - point) : back_;
}

bool Projection::isVisible(const Vec3& point) const {
  return !isPerspective_ || distance_ - core::dot(point - target_, back_) > 0.01 * distance_;
}

}  // namespace espalier::turtle
