#include "engine/turtle/export/picture/ground_shade.h"

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"
#include "engine/turtle/export/mesh/placed_meshes.h"

namespace espalier::turtle {

namespace {

constexpr double kLeastHeight = 0.13;  // of a spot over its width: the ground is never quite an edge
constexpr double kSteepest = 0.9;      // sine of the camera's elevation from which a plant is seen from above
constexpr double kShade = 0.2;         // at the middle
constexpr double kFootShade = 0.28;    // more, close to the stem
constexpr double kFoot = 0.22;         // of the spot's size
constexpr double kRoom = 0.8;          // of a spot below and beside its middle, of its radius

bool seesGround(const Projection& projection) {
  return std::abs(projection.towardViewer().y) <= kSteepest && projection.up().y > 0.3;
}

// height of a circle on the ground over its width
double flatness(const Projection& projection) {
  return std::max(kLeastHeight, std::abs(projection.towardViewer().y));
}

}  // namespace

void GroundShade::add(std::span<const GroundContact> contacts, const ScenePlacement& placement) {
  for (const GroundContact& contact : contacts) {
    contacts_.push_back({placedPoint(placement, contact.place), placement.scale * contact.radius});
  }
}

void GroundShade::include(const Projection& projection, PictureBounds& bounds) const {
  if (!seesGround(projection)) {
    return;
  }
  for (const GroundContact& contact : contacts_) {
    if (projection.isVisible(contact.place)) {
      const ProjectedPoint middle = projection.project(contact.place);
      const double room = kRoom * contact.radius * middle.magnification;
      for (const double side : {-room, room}) {
        ProjectedPoint edge = middle;
        edge.x += side;
        edge.y -= room * flatness(projection);
        bounds.include(edge, 0.0);
      }
    }
  }
}

void GroundShade::place(const RasterCamera& camera) {
  if (!seesGround(camera.projection())) {
    return;
  }
  for (const GroundContact& contact : contacts_) {
    if (camera.isVisible(contact.place)) {
      const PagePoint point = camera.onPage(contact.place);
      const double radius = contact.radius * point.pixelsPerUnit;
      spots_.push_back({point.x, point.y, radius, radius * flatness(camera.projection())});
    }
  }
}

void GroundShade::row(int y, std::span<float> shades) const {
  std::ranges::fill(shades, 0.0F);
  for (const Spot& spot : spots_) {
    const double v = (y + 0.5 - spot.y) / spot.radiusY;
    if (!(std::abs(v) < 1.0)) {
      continue;
    }
    const double half = spot.radiusX * std::sqrt(1.0 - v * v);
    const auto last = static_cast<double>(shades.size());
    const auto begin = static_cast<std::size_t>(std::clamp(spot.x - half, 0.0, last));
    const auto end = static_cast<std::size_t>(std::clamp(std::ceil(spot.x + half), 0.0, last));
    for (std::size_t x = begin; x < end; ++x) {
      const double u = (static_cast<double>(x) + 0.5 - spot.x) / spot.radiusX;
      const double d = std::min(1.0, u * u + v * v);
      const double falloff = (1.0 - d) * (1.0 - d);
      const double shade = kShade * falloff + kFootShade * core::exp(-d / (kFoot * kFoot)) * falloff;
      // spots that meet do not add up to black
      shades[x] = std::max(shades[x], static_cast<float>(shade));
    }
  }
}

}  // namespace espalier::turtle
