#include "engine/turtle/export/raster_geometry.h"

#include <array>
#include <cmath>

#include "engine/turtle/export/polygon_mesh.h"
#include "engine/turtle/export/raster_pen.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr int kDiscSides = 24;
constexpr double kSharpestJoint = -0.7;  // cosine of the largest turn that two pieces of a line can share a ring at

Vec3 directionOf(const Segment& segment) {
  const Vec3 d = segment.end - segment.start;
  return core::length(d) > 0.0 ? core::normalised(d) : segment.frame.heading;
}

}  // namespace

RasterGeometry::RasterGeometry(const Scene& scene, const language::ViewSettings& view)
    : scene_(scene), view_(view), continuation_(scene.segments.size(), kNoParent) {
  for (std::uint32_t i = 0; i < scene.segments.size(); ++i) {
    const Segment& segment = scene.segments[i];
    const std::uint32_t parent = segment.parent;
    if (parent >= i || continuation_[parent] != kNoParent) {
      continue;
    }
    const Segment& before = scene.segments[parent];
    if (before.end == segment.start && before.branchOrder == segment.branchOrder && before.plant == segment.plant &&
        core::dot(directionOf(before), directionOf(segment)) > kSharpestJoint) {
      continuation_[parent] = i;
    }
  }
}

std::size_t RasterGeometry::partCount() const {
  return scene_.cylinders.size() + scene_.surfaces.size() + scene_.patches.size() + scene_.polygons.size() +
         scene_.segments.size() + scene_.balls.size() + scene_.labels.size();
}

RasterGeometry::Part RasterGeometry::partAt(std::size_t part) const {
  const std::array<std::size_t, 7> counts{scene_.cylinders.size(), scene_.surfaces.size(), scene_.patches.size(),
                                          scene_.polygons.size(),  scene_.segments.size(), scene_.balls.size(),
                                          scene_.labels.size()};
  std::size_t kind = 0;
  while (part >= counts[kind]) {
    part -= counts[kind];
    ++kind;
  }
  return {static_cast<Kind>(kind), part};
}

bool RasterGeometry::joins(std::uint32_t segment) const {
  const std::uint32_t parent = scene_.segments[segment].parent;
  return parent < segment && continuation_[parent] == segment;
}

Mesh RasterGeometry::meshOf(const Part& part, std::int32_t& colour) const {
  Mesh mesh;
  switch (part.kind) {
    case Kind::Cylinder:
      colour = scene_.cylinders[part.index].points.front().colour;
      appendCylinder(mesh, scene_.cylinders[part.index], view_);
      break;
    case Kind::Surface:
      colour = scene_.surfaces[part.index].colour;
      appendSurface(mesh, scene_.surfaces[part.index], view_);
      break;
    case Kind::Patch: {
      const Patch& patch = scene_.patches[part.index];
      colour = patch.colour;
      appendPatch(mesh, patch.points, patch.subdivisionS, patch.subdivisionT);
      break;
    }
    case Kind::Polygon:
      colour = scene_.polygons[part.index].colour;
      appendPolygon(mesh, scene_.polygons[part.index].vertices);
      break;
    case Kind::Ball:
      colour = scene_.balls[part.index].colour;
      appendDisc(mesh, scene_.balls[part.index], kDiscSides);
      break;
    case Kind::Segment:
    case Kind::Label:
      break;
  }
  return mesh;
}

void RasterGeometry::include(std::size_t number, const Projection& projection, PictureBounds& bounds) const {
  const Part part = partAt(number);
  if (part.kind == Kind::Segment) {
    const Segment& segment = scene_.segments[part.index];
    const bool hasWidth = scene_.lineStyle != language::LineStyle::Pixel;
    const ProjectedPoint a = projection.project(segment.start);
    const ProjectedPoint b = projection.project(segment.end);
    bounds.include(a, hasWidth ? 0.5 * segment.startWidth * a.magnification : 0.0);
    bounds.include(b, hasWidth ? 0.5 * segment.endWidth * b.magnification : 0.0);
    return;
  }
  if (part.kind == Kind::Label) {
    bounds.include(projection.project(scene_.labels[part.index].position), 0.0);
    return;
  }
  if (part.kind == Kind::Ball && scene_.balls[part.index].kind != Ball::Kind::Disc) {
    const Ball& ball = scene_.balls[part.index];
    const ProjectedPoint p = projection.project(ball.centre);
    bounds.include(p, 0.5 * ball.diameter * p.magnification);
    return;
  }
  std::int32_t colour = 0;
  for (const Vec3& position : meshOf(part, colour).positions) {
    bounds.include(projection.project(position), 0.0);
  }
}

bool RasterGeometry::isVisible(std::size_t number, const Projection& projection) const {
  const Part part = partAt(number);
  if (part.kind == Kind::Segment) {
    const Segment& segment = scene_.segments[part.index];
    return projection.isVisible(segment.start) && projection.isVisible(segment.end);
  }
  if (part.kind == Kind::Label) {
    return projection.isVisible(scene_.labels[part.index].position);
  }
  if (part.kind == Kind::Ball) {
    const Ball& ball = scene_.balls[part.index];
    return projection.isVisible(ball.centre + 0.5 * ball.diameter * projection.towardViewer());
  }
  std::int32_t colour = 0;
  for (const Vec3& position : meshOf(part, colour).positions) {
    if (!projection.isVisible(position)) {
      return false;
    }
  }
  return true;
}

void RasterGeometry::append(std::size_t number, const RasterCamera& camera, const RasterShading& shading,
                            std::vector<RasterTriangle>& triangles) const {
  const Part part = partAt(number);
  if (!isVisible(number, camera.projection())) {
    return;
  }
  const auto organ = static_cast<std::uint32_t>(number);
  if (part.kind == Kind::Segment) {
    const auto index = static_cast<std::uint32_t>(part.index);
    const Segment& segment = scene_.segments[index];
    const Look look = shading.lookOf(segment);
    RasterPen pen(camera, shading, look, organ, triangles);
    const Vec3 direction = directionOf(segment);
    LineEnd start{segment.start, direction, segment.frame.left, 0.5 * segment.startWidth, LineEnd::Shape::Round};
    LineEnd end{segment.end, direction, segment.frame.left, 0.5 * segment.endWidth, LineEnd::Shape::Round};
    if (segment.parent == kNoParent) {
      start.shape = LineEnd::Shape::Flat;
    } else if (segment.parent < index && scene_.segments[segment.parent].end == segment.start) {
      start.shape = LineEnd::Shape::Joint;  // within the line that it branches from
    }
    // where a line goes on, both pieces end in the plane that halves their angle
    if (joins(index)) {
      start.tangent = core::normalised(direction + directionOf(scene_.segments[segment.parent]));
      start.shape = LineEnd::Shape::Joint;
    }
    if (const std::uint32_t next = continuation_[index]; next != kNoParent) {
      end.tangent = core::normalised(direction + directionOf(scene_.segments[next]));
      end.shape = LineEnd::Shape::Joint;
    }
    switch (scene_.lineStyle) {
      case language::LineStyle::Pixel:
        return pen.pixelLine(start, end);
      case language::LineStyle::Polygon:
        return pen.strip(start, end);
      case language::LineStyle::Cylinder:
        return pen.roundLine(start, end);
    }
  }
  if (part.kind == Kind::Label) {
    const Label& label = scene_.labels[part.index];
    const Look look = shading.lookOfIndex(label.colour);
    return RasterPen(camera, shading, look, organ, triangles).text(label.position, label.text);
  }
  if (part.kind == Kind::Ball && scene_.balls[part.index].kind != Ball::Kind::Disc) {
    const Ball& ball = scene_.balls[part.index];
    const Look look = shading.lookOfIndex(ball.colour);
    RasterPen pen(camera, shading, look, organ, triangles);
    return ball.kind == Ball::Kind::Sphere ? pen.ball(ball.centre, 0.5 * ball.diameter)
                                           : pen.screenDisc(ball.centre, 0.5 * ball.diameter);
  }
  std::int32_t colour = 0;
  const Mesh mesh = meshOf(part, colour);
  const Look look = shading.lookOfIndex(colour);
  RasterPen(camera, shading, look, organ, triangles).mesh(mesh);
}

}  // namespace espalier::turtle
