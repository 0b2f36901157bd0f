#include "engine/turtle/scene/scene_bounds.h"

#include <algorithm>

#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::turtle {

using core::Vec3;

std::optional<files::Box> boundsOf(const Scene& scene, const files::ViewSettings& view) {
  std::optional<files::Box> box;
  const auto include = [&](const Vec3& p) {
    if (!box) {
      box = files::Box{p, p};
      return;
    }
    box->minimum = {std::min(box->minimum.x, p.x), std::min(box->minimum.y, p.y), std::min(box->minimum.z, p.z)};
    box->maximum = {std::max(box->maximum.x, p.x), std::max(box->maximum.y, p.y), std::max(box->maximum.z, p.z)};
  };
  for (const Segment& segment : scene.segments) {
    include(segment.start);
    include(segment.end);
  }
  for (const Polygon& polygon : scene.polygons) {
    std::for_each(polygon.vertices.begin(), polygon.vertices.end(), include);
  }
  for (const Ball& ball : scene.balls) {
    const double radius = 0.5 * ball.diameter;
    include(ball.centre - Vec3{radius, radius, radius});
    include(ball.centre + Vec3{radius, radius, radius});
  }
  Mesh mesh;
  for (const SurfaceInstance& surface : scene.surfaces) {
    mesh.clear();
    appendSurface(mesh, surface, view);
    std::for_each(mesh.positions.begin(), mesh.positions.end(), include);
  }
  for (const GeneralizedCylinder& cylinder : scene.cylinders) {
    for (const CylinderPoint& point : cylinder.points) {
      include(point.position);
    }
  }
  for (const Patch& patch : scene.patches) {
    std::for_each(patch.points.begin(), patch.points.end(), include);
  }
  for (const Label& label : scene.labels) {
    include(label.position);
  }
  return box;
}

}  // namespace espalier::turtle
