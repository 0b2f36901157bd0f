#include "engine/turtle/export/picture/raster_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "engine/core/check.h"
#include "engine/turtle/export/mesh/cylinder_mesh.h"
#include "engine/turtle/export/mesh/placed_meshes.h"
#include "engine/turtle/export/mesh/polygon_mesh.h"
#include "engine/turtle/export/picture/raster_pen.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr int kLeastTubeSides = 12;
constexpr int kMostTubeSides = 64;
constexpr std::size_t kLongCylinder = 2 * kLongestRun;  // control points beyond which it is drawn in pieces
constexpr std::size_t kFewTriangles = 32;               // of a line, ball, label or tube
constexpr double kSharpestJoint = -0.7;  // cosine of the largest turn that two pieces of a line can share a ring at

Vec3 directionOf(const Segment& segment) {
  const Vec3 d = segment.end - segment.start;
  return core::length(d) > 0.0 ? core::normalised(d) : segment.frame.heading;
}

}  // namespace

RasterGeometry::RasterGeometry(const Scene& scene, const files::ViewSettings& view, const Palette& palette,
                               core::WorkerTeam& team)
    : scene_(scene),
      view_(view),
      palette_(palette),
      look_(lineLookOf(scene, view)),
      continuation_(continuationsOf(scene, kSharpestJoint, team)) {
  hasTubes_ = look_.style == files::LineStyle::Cylinder &&
              std::ranges::any_of(scene.segments, [](const Segment& segment) { return segment.texture > 0; });
  if (hasTubes_) {
    chains_ = chainsOf(scene, palette, look_, team);
    tubeCircle_ = tubeCircle(std::clamp(view.contourSides, kLeastTubeSides, kMostTubeSides));
    std::ranges::copy_if(chains_.heads, std::back_inserter(tubes_),
                         [&](std::uint32_t head) { return scene.segments[head].texture > 0; });
  }
  const std::array<std::size_t, kKindCount> counts{
      scene_.cylinders.size(), scene_.surfaces.size(), scene_.patches.size(), scene_.polygons.size(),
      tubes_.size(),           scene_.segments.size(), scene_.balls.size(),   scene_.labels.size()};
  std::exclusive_scan(counts.begin(), counts.end(), firstParts_.begin(), std::size_t{0});
  for (const files::Surface& surface : view.surfaces) {
    appendLocalSurface(surfaces_.emplace_back(), surface);
  }
  for (const files::TriangleSurface& surface : view.triangleSurfaces) {
    appendLocalSurface(surfaces_.emplace_back(), surface);
  }
  for (std::size_t i = 0; i < view.surfaces.size(); ++i) {
    surfaces_.push_back(surfaces_[i]);
    setWholeCoordinates(surfaces_.back());
  }
}

std::size_t RasterGeometry::partCount() const {
  return firstParts_.back() + scene_.labels.size();
}

RasterGeometry::Part RasterGeometry::partAt(std::size_t part) const {
  std::size_t kind = kKindCount - 1;
  while (part < firstParts_[kind]) {
    --kind;
  }
  return {static_cast<Kind>(kind), part - firstParts_[kind]};
}

bool RasterGeometry::joins(std::uint32_t segment) const {
  const std::uint32_t parent = scene_.segments[segment].parent;
  return parent < segment && continuation_[parent] == segment;
}

const Mesh& RasterGeometry::localSurface(const SurfaceInstance& instance) const {
  const std::size_t bicubic = view_.surfaces.size();
  const std::size_t all = bicubic + view_.triangleSurfaces.size();
  ESPALIER_CHECK(instance.surface < (instance.isTriangleSurface ? all - bicubic : bicubic));
  if (instance.isTriangleSurface) {
    return surfaces_[bicubic + instance.surface];
  }
  const bool isWhole =
      instance.texture > 0 && view_.textures[static_cast<std::size_t>(instance.texture) - 1].isPerSurface;
  return surfaces_[(isWhole ? all : 0) + instance.surface];
}

void RasterGeometry::forMeshes(const Part& part, const ScenePlacement& placement,
                               const std::function<void(const Mesh&, const Wear&)>& use) const {
  Mesh mesh;
  const auto give = [&](const Wear& wear) {
    place(mesh, placement);
    use(mesh, wear);
  };
  switch (part.kind) {
    case Kind::Cylinder: {
      const GeneralizedCylinder& cylinder = scene_.cylinders[part.index];
      const SweptCylinder swept(cylinder, view_);
      for (const CylinderRun& run : swept.runs()) {
        mesh.clear();
        swept.appendRun(mesh, run);
        give({run.colour, cylinder.texture});
      }
      return;
    }
    case Kind::Surface: {
      const SurfaceInstance& instance = scene_.surfaces[part.index];
      appendPlaced(mesh, localSurface(instance), {instance.position, instance.frame, instance.scale});
      return give({instance.colour, instance.texture});
    }
    case Kind::Patch: {
      const Patch& patch = scene_.patches[part.index];
      appendPatch(mesh, patch.points, patch.subdivisionS, patch.subdivisionT);
      return give({patch.colour, patch.texture});
    }
    case Kind::Polygon:
      appendPolygon(mesh, scene_.polygons[part.index].vertices);
      return give({scene_.polygons[part.index].colour, 0});
    case Kind::Tube: {
      const Segment& head = scene_.segments[tubes_[part.index]];
      appendTube(mesh, tubeOf(scene_, palette_, chains_, tubes_[part.index], look_), tubeCircle_,
                 view_.textures[static_cast<std::size_t>(head.texture) - 1].ratio);
      return give({head.colour, head.texture});
    }
    case Kind::Ball:
      appendDisc(mesh, scene_.balls[part.index], kDiscSides);
      return give({scene_.balls[part.index].colour, 0});
    case Kind::Segment:
    case Kind::Label:
      return;
  }
}

void RasterGeometry::include(std::size_t number, const ScenePlacement& placement, const Projection& projection,
                             PictureBounds& bounds) const {
  const Part part = partAt(number);
  const auto projected = [&](const Vec3& point) { return projection.project(placedPoint(placement, point)); };
  if (part.kind == Kind::Segment) {
    const Segment& segment = scene_.segments[part.index];
    const double halfWidth = look_.style != files::LineStyle::Pixel ? 0.5 * placement.scale : 0.0;
    const ProjectedPoint a = projected(segment.start);
    const ProjectedPoint b = projected(segment.end);
    bounds.include(a, halfWidth * look_.startWidth(segment) * a.magnification);
    bounds.include(b, halfWidth * look_.endWidth(segment) * b.magnification);
    return;
  }
  if (part.kind == Kind::Label) {
    bounds.include(projected(scene_.labels[part.index].position), 0.0);
    return;
  }
  if (part.kind == Kind::Ball && scene_.balls[part.index].kind != Ball::Kind::Disc) {
    const Ball& ball = scene_.balls[part.index];
    const ProjectedPoint p = projected(ball.centre);
    bounds.include(p, 0.5 * placement.scale * ball.diameter * p.magnification);
    return;
  }
  if (part.kind == Kind::Tube) {
    return;  // its segments count
  }
  forMeshes(part, placement, [&](const Mesh& mesh, const Wear&) {
    for (const Vec3& position : mesh.positions) {
      bounds.include(projection.project(position), 0.0);
    }
  });
}

bool RasterGeometry::isVisible(std::size_t number, const ScenePlacement& placement,
                               const Projection& projection) const {
  const Part part = partAt(number);
  const auto isSeen = [&](const Vec3& point) { return projection.isVisible(placedPoint(placement, point)); };
  if (part.kind == Kind::Segment) {
    const Segment& segment = scene_.segments[part.index];
    return isSeen(segment.start) && isSeen(segment.end);
  }
  if (part.kind == Kind::Label) {
    return isSeen(scene_.labels[part.index].position);
  }
  if (part.kind == Kind::Ball) {
    const Ball& ball = scene_.balls[part.index];
    return projection.isVisible(placedPoint(placement, ball.centre) +
                                0.5 * placement.scale * ball.diameter * projection.towardViewer());
  }
  if (!projection.isPerspective()) {
    return true;
  }
  bool isAllSeen = true;
  forMeshes(part, placement, [&](const Mesh& mesh, const Wear&) {
    isAllSeen =
        isAllSeen && std::ranges::all_of(mesh.positions, [&](const Vec3& p) { return projection.isVisible(p); });
  });
  return isAllSeen;
}

void RasterGeometry::appendSegment(std::uint32_t index, const ScenePlacement& placement, RasterPen& pen) const {
  const Segment& segment = scene_.segments[index];
  const auto turned = [&placement](const Vec3& v) { return placedDirection(placement, v); };
  // pixels have no scale
  const double half = look_.style == files::LineStyle::Pixel ? 0.5 : 0.5 * placement.scale;
  const Vec3 direction = directionOf(segment);
  const Vec3 left = turned(segment.frame.left);
  LineEnd start{placedPoint(placement, segment.start), turned(direction), left, half * look_.startWidth(segment),
                LineEnd::Shape::Round};
  LineEnd end{placedPoint(placement, segment.end), turned(direction), left, half * look_.endWidth(segment),
              LineEnd::Shape::Round};
  if (segment.parent == kNoParent) {
    start.shape = LineEnd::Shape::Flat;
  } else if (segment.parent < index && scene_.segments[segment.parent].end == segment.start) {
    start.shape = LineEnd::Shape::Joint;  // within the line that it branches from
  }
  // where a line goes on, both pieces end in the plane that halves their angle
  if (joins(index)) {
    start.tangent = turned(core::normalised(direction + directionOf(scene_.segments[segment.parent])));
    start.shape = LineEnd::Shape::Joint;
  }
  if (const std::uint32_t next = continuation_[index]; next != kNoParent) {
    end.tangent = turned(core::normalised(direction + directionOf(scene_.segments[next])));
    end.shape = LineEnd::Shape::Joint;
  }
  switch (look_.style) {
    case files::LineStyle::Pixel:
      return pen.pixelLine(start, end);
    case files::LineStyle::Polygon:
      return pen.strip(start, end);
    case files::LineStyle::Cylinder:
      return appendRoundLine(index, start, end, pen);
  }
}

// a limb that goes on with the tube of a fork takes its own width over a short way
void RasterGeometry::appendRoundLine(std::uint32_t index, LineEnd start, const LineEnd& end, RasterPen& pen) const {
  const Segment& segment = scene_.segments[index];
  const bool isLimb = joins(index) && scene_.segments[segment.parent].branchOrder != segment.branchOrder;
  const double radius =
      isLimb ? start.radius * look_.endWidth(scene_.segments[segment.parent]) / look_.startWidth(segment) : 0.0;
  const double length = core::length(end.place - start.place);
  if (!isLimb || radius == start.radius || !(length > 0.0) || !std::isfinite(radius)) {
    return pen.roundLine(start, end);
  }
  const double share = std::min(0.5, kCollarRadii * std::max(radius, start.radius) / length);
  LineEnd collar = end;
  collar.place = start.place + share * (end.place - start.place);
  collar.tangent = core::normalised(end.place - start.place);
  collar.radius = start.radius + share * (end.radius - start.radius);
  collar.shape = LineEnd::Shape::Joint;
  start.radius = radius;
  pen.roundLine(start, collar);
  pen.roundLine(collar, end);
}

void RasterGeometry::append(std::size_t number, const ScenePlacement& placement, const RasterCamera& camera,
                            const RasterShading& shading, std::uint32_t organ,
                            std::vector<RasterTriangle>& triangles) const {
  const Part part = partAt(number);
  if (!isVisible(number, placement, camera.projection())) {
    return;
  }
  if (part.kind == Kind::Segment) {
    const Segment& segment = scene_.segments[part.index];
    if (isPartOfTube(segment)) {
      return;
    }
    const Look look = shading.lookOf(segment);
    RasterPen pen(camera, shading, look, organ, triangles);
    return appendSegment(static_cast<std::uint32_t>(part.index), placement, pen);
  }
  if (part.kind == Kind::Label) {
    const Label& label = scene_.labels[part.index];
    const Look look = shading.lookOfIndex(label.colour);
    return RasterPen(camera, shading, look, organ, triangles).text(placedPoint(placement, label.position), label.text);
  }
  if (part.kind == Kind::Ball && scene_.balls[part.index].kind != Ball::Kind::Disc) {
    const Ball& ball = scene_.balls[part.index];
    const Look look = shading.lookOfIndex(ball.colour);
    RasterPen pen(camera, shading, look, organ, triangles);
    const Vec3 centre = placedPoint(placement, ball.centre);
    const double radius = 0.5 * placement.scale * ball.diameter;
    return ball.kind == Ball::Kind::Sphere ? pen.ball(centre, radius) : pen.screenDisc(centre, radius);
  }
  forMeshes(part, placement, [&](const Mesh& mesh, const Wear& wear) {
    const bool isTube = part.kind == Kind::Tube;
    Look look =
        isTube ? shading.lookOf(scene_.segments[tubes_[part.index]]) : shading.lookOfIndex(wear.colour, wear.texture);
    look.isThin = !isTube && part.kind != Kind::Cylinder;
    RasterPen(camera, shading, look, organ, triangles).mesh(mesh);
  });
}

std::shared_ptr<const SweptCylinder> RasterGeometry::longCylinder(std::size_t number) const {
  const Part part = partAt(number);
  if (part.kind != Kind::Cylinder || scene_.cylinders[part.index].points.size() <= kLongCylinder) {
    return nullptr;
  }
  return std::make_shared<SweptCylinder>(scene_.cylinders[part.index], view_);
}

void RasterGeometry::appendRun(std::size_t number, const SweptCylinder& cylinder, const CylinderRun& run,
                               const ScenePlacement& placement, const RasterCamera& camera,
                               const RasterShading& shading, std::uint32_t organ,
                               std::vector<RasterTriangle>& triangles) const {
  Mesh mesh;
  cylinder.appendRun(mesh, run);
  place(mesh, placement);
  const Look look = shading.lookOfIndex(run.colour, scene_.cylinders[partAt(number).index].texture);
  RasterPen(camera, shading, look, organ, triangles).mesh(mesh);
}

std::size_t RasterGeometry::triangleCountOf(std::size_t number) const {
  const Part part = partAt(number);
  switch (part.kind) {
    case Kind::Cylinder: {
      std::size_t strips = 0;
      std::size_t sides = 0;
      for (const CylinderPoint& point : scene_.cylinders[part.index].points) {
        strips += static_cast<std::size_t>(point.stripCount);
        sides = std::max(sides, static_cast<std::size_t>(point.sideCount));
      }
      return 2 * strips * sides;
    }
    case Kind::Surface:
      return 2 * localSurface(scene_.surfaces[part.index]).faces.size();
    case Kind::Patch: {
      const Patch& patch = scene_.patches[part.index];
      return 2 * static_cast<std::size_t>(patch.subdivisionS) * static_cast<std::size_t>(patch.subdivisionT);
    }
    case Kind::Polygon:
      return scene_.polygons[part.index].vertices.size();
    case Kind::Tube:
    case Kind::Segment:
    case Kind::Ball:
    case Kind::Label:
      break;
  }
  return kFewTriangles;
}

}  // namespace espalier::turtle
