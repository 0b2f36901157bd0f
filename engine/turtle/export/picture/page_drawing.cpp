#include "engine/turtle/export/picture/page_drawing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "engine/core/polygon.h"
#include "engine/turtle/export/mesh/cylinder_mesh.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kThinnestLine = 0.5;  // page units
constexpr Colour kDark{22, 26, 30};
constexpr Colour kShine{255, 255, 250};

Colour lit(const Colour& colour, double factor) {
  return factor <= 1.0 ? mixed(kDark, colour, factor) : mixed(colour, kShine, factor - 1.0);
}

/// The mean of a part of a texture over a colour, and how opaque it is.
struct Worn {
  Colour colour;
  double opacity = 1.0;
};

// the part around a place, of an area in texture coordinates; 1: all of the texture
Worn wornBy(const Colour& below, const RasterTexture* texture, const std::array<double, 2>& place, double area) {
  if (texture == nullptr) {
    return {below, 1.0};
  }
  const std::array<float, 4> sample = texture->at(place[0], place[1], texture->levelOf(area, 1.0));
  const auto component = [&](unsigned char own, float mean) {
    const double base = texture->hidesColour() ? 255.0 : own;
    return static_cast<unsigned char>(std::clamp(base * static_cast<double>(mean) + 0.5, 0.0, 255.0));
  };
  return {{component(below.red, sample[0]), component(below.green, sample[1]), component(below.blue, sample[2])},
          static_cast<double>(sample[3])};
}

}  // namespace

PageDrawing::PageDrawing(const Scene& scene, const files::ViewSettings& view, const Palette& palette, double width,
                         double height, double marginFraction, const std::optional<PictureFrame>& frame)
    : scene_(scene),
      view_(view),
      palette_(palette),
      look_(lineLookOf(scene, view)),
      projection_(view),
      textures_(view) {
  light_ = core::normalised(-0.45 * projection_.right() + 0.75 * projection_.up() + 0.6 * projection_.towardViewer());
  if (!frame) {
    chooseProjection();
  } else if (frame->isParallel) {
    projection_.useParallel();
  }
  for (const Segment& segment : scene.segments) {
    const ProjectedPoint a = projection_.project(segment.start);
    const ProjectedPoint b = projection_.project(segment.end);
    bounds_.include(a, hasPixelLines() ? 0.0 : look_.startWidth(segment) * a.magnification / 2.0);
    bounds_.include(b, hasPixelLines() ? 0.0 : look_.endWidth(segment) * b.magnification / 2.0);
  }
  addShapes();
  bounds_ = frame ? frame->bounds : bounds_;
  fit(width, height, marginFraction);
  addLines();
}

// a perspective whose viewer stands inside the scene shows nothing sensible: draw it in parallel
void PageDrawing::chooseProjection() {
  const bool isClear = std::all_of(scene_.segments.begin(), scene_.segments.end(), [&](const Segment& segment) {
    return projection_.isVisible(segment.start) && projection_.isVisible(segment.end);
  });
  if (!isClear) {
    projection_.useParallel();
  }
}

void PageDrawing::addFace(std::span<const Vec3> corners, const Vec3& normal, std::int32_t colour) {
  addFace(corners, normal, palette_.ofIndex(colour), palette_.opacityOfIndex(colour));
}

void PageDrawing::addFace(std::span<const Vec3> corners, const Vec3& normal, const Colour& colour, double opacity) {
  PageShape shape;
  shape.firstPoint = static_cast<std::uint32_t>(points_.size());
  shape.pointCount = static_cast<std::uint32_t>(corners.size());
  for (const Vec3& corner : corners) {
    const ProjectedPoint p = projection_.project(corner);
    bounds_.include(p, 0.0);
    points_.push_back({p.x, p.y});
    shape.depth += p.depth / static_cast<double>(corners.size());
  }
  shape.opacity = opacity;
  shape.colour = lit(colour, 0.68 + 0.36 * std::abs(core::dot(normal, light_)));
  shapes_.push_back(shape);
}

void PageDrawing::addMesh(const Mesh& mesh, std::int32_t colour, std::int32_t texture) {
  const Colour own = palette_.ofIndex(colour);
  const RasterTexture* const picture = textures_.find(texture, own);
  std::vector<Vec3> corners;
  std::vector<std::array<double, 2>> places;  // of the corners in the texture
  for (const auto& face : mesh.faces) {
    corners.clear();
    places.clear();
    Vec3 normal;
    for (const std::uint32_t vertex : face) {
      if (vertex != Mesh::kNoVertex) {
        corners.push_back(mesh.positions[vertex]);
        places.push_back(mesh.coordinates[vertex]);
        normal = normal + mesh.normals[vertex];
      }
    }
    std::array<double, 2> middle{};
    double area = 0.0;
    for (std::size_t k = 0; k < places.size(); ++k) {
      const auto& next = places[(k + 1) % places.size()];
      area += 0.5 * (places[k][0] * next[1] - places[k][1] * next[0]);
      middle[0] += places[k][0] / static_cast<double>(places.size());
      middle[1] += places[k][1] / static_cast<double>(places.size());
    }
    const Worn worn = wornBy(own, picture, middle, std::abs(area));
    if (worn.opacity >= 0.5) {
      addFace(corners, core::normalised(normal), worn.colour, palette_.opacityOfIndex(colour));
    }
  }
}

void PageDrawing::addShapes() {
  for (const Polygon& polygon : scene_.polygons) {
    addFace(polygon.vertices, core::normalised(core::newellNormal(polygon.vertices)), polygon.colour);
  }
  Mesh mesh;
  for (const Ball& ball : scene_.balls) {
    if (ball.kind == Ball::Kind::Disc) {
      mesh.clear();
      appendDisc(mesh, ball, kDiscSides);
      addFace(std::span(mesh.positions).subspan(1, kDiscSides), ball.frame.up, ball.colour);
      continue;
    }
    const ProjectedPoint p = projection_.project(ball.centre);
    PageShape shape;
    shape.kind = ball.kind == Ball::Kind::Sphere ? PageShape::Kind::Sphere : PageShape::Kind::Disc;
    shape.depth = p.depth - ball.diameter / 2.0;
    shape.radius = ball.diameter / 2.0 * p.magnification;
    shape.firstPoint = static_cast<std::uint32_t>(points_.size());
    shape.pointCount = 1;
    shape.colour = palette_.ofIndex(ball.colour);
    shape.opacity = palette_.opacityOfIndex(ball.colour);
    bounds_.include(p, shape.radius);
    points_.push_back({p.x, p.y});
    shapes_.push_back(shape);
  }
  for (const SurfaceInstance& surface : scene_.surfaces) {
    mesh.clear();
    appendSurface(mesh, surface, view_);
    addMesh(mesh, surface.colour, surface.texture);
  }
  for (const Patch& patch : scene_.patches) {
    mesh.clear();
    appendPatch(mesh, patch.points, patch.subdivisionS, patch.subdivisionT);
    addMesh(mesh, patch.colour, patch.texture);
  }
  for (const GeneralizedCylinder& cylinder : scene_.cylinders) {
    const SweptCylinder swept(cylinder, view_);
    for (const CylinderRun& run : swept.runs()) {
      mesh.clear();
      swept.appendRun(mesh, run);
      addMesh(mesh, run.colour, cylinder.texture);
    }
  }
  for (std::size_t i = 0; i < scene_.labels.size(); ++i) {
    const ProjectedPoint p = projection_.project(scene_.labels[i].position);
    PageShape shape;
    shape.kind = PageShape::Kind::Text;
    // text is for reading: before everything else
    shape.depth = -std::numeric_limits<double>::infinity();
    shape.firstPoint = static_cast<std::uint32_t>(points_.size());
    shape.pointCount = 1;
    shape.colour = palette_.ofIndex(scene_.labels[i].colour);
    shape.label = static_cast<std::uint32_t>(i);
    bounds_.include(p, 0.0);
    points_.push_back({p.x, p.y});
    shapes_.push_back(shape);
  }
  // far to near; equal depths keep the order of drawing
  std::stable_sort(shapes_.begin(), shapes_.end(),
                   [](const PageShape& a, const PageShape& b) { return a.depth > b.depth; });
}

void PageDrawing::fit(double width, double height, double marginFraction) {
  const double spanX = bounds_.empty() ? 0.0 : bounds_.right - bounds_.left;
  const double spanY = bounds_.empty() ? 0.0 : bounds_.top - bounds_.bottom;
  const double margin = std::max(width, height) * marginFraction;
  const double scaleX = spanX > 0.0 ? (width - 2.0 * margin) / spanX : std::numeric_limits<double>::infinity();
  const double scaleY = spanY > 0.0 ? (height - 2.0 * margin) / spanY : std::numeric_limits<double>::infinity();
  scale_ = std::isfinite(std::min(scaleX, scaleY)) ? std::min(scaleX, scaleY) : 1.0;
  width_ = scale_ * spanX + 2.0 * margin;
  height_ = scale_ * spanY + 2.0 * margin;
  if (!bounds_.empty()) {
    offsetX_ = margin - scale_ * bounds_.left;
    offsetY_ = margin + scale_ * bounds_.top;
  }
  for (PageShape& shape : shapes_) {
    shape.radius = std::max(scale_ * shape.radius, kThinnestLine / 2.0);
  }
}

void PageDrawing::addLines() {
  using Key = std::tuple<std::uint32_t, std::uint32_t, double>;  // order, colour, opacity
  std::map<Key, std::size_t> groups;
  for (std::uint32_t i = 0; i < scene_.segments.size(); ++i) {
    const Segment& segment = scene_.segments[i];
    const Colour plain = palette_.ofSegment(segment);
    const Colour colour = wornBy(plain, textures_.find(segment.texture, plain), {0.5, 0.5}, 1.0).colour;
    const double opacity = palette_.opacityOfIndex(segment.colour);
    const std::uint32_t packed =
        static_cast<std::uint32_t>(colour.red) << 16U | static_cast<std::uint32_t>(colour.green) << 8U | colour.blue;
    const auto [group, isNew] = groups.try_emplace({segment.branchOrder, packed, opacity}, lines_.size());
    if (isNew) {
      lines_.push_back({segment.branchOrder, colour, opacity, 2.0 * radius(segment, false), {}});
    }
    PageLines& lines = lines_[group->second];
    lines.segments.push_back(i);
    if (lines.width != 2.0 * radius(segment, false) || lines.width != 2.0 * radius(segment, true)) {
      lines.width = 0.0;
    }
  }
  std::stable_sort(lines_.begin(), lines_.end(),
                   [](const PageLines& a, const PageLines& b) { return a.order < b.order; });
}

PagePlace PageDrawing::point(const PageShape& shape, std::uint32_t corner) const {
  const auto& p = points_[shape.firstPoint + corner];
  return {offsetX_ + scale_ * p[0], offsetY_ - scale_ * p[1]};
}

PagePlace PageDrawing::place(const Vec3& position) const {
  const ProjectedPoint p = projection_.project(position);
  return {offsetX_ + scale_ * p.x, offsetY_ - scale_ * p.y};
}

double PageDrawing::radius(const Segment& segment, bool isEnd) const {
  const double width = isEnd ? look_.endWidth(segment) : look_.startWidth(segment);
  const double seen =
      hasPixelLines() ? width : width * scale_ * projection_.project(isEnd ? segment.end : segment.start).magnification;
  return std::max(seen, kThinnestLine) / 2.0;
}

}  // namespace espalier::turtle
