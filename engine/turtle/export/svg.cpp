#include "engine/turtle/export/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "engine/turtle/export/mesh.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/projection.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kThinnestLine = 0.5;   // pixels
constexpr double kHighlightFrom = 3.0;  // line width in pixels from which a branch gets a highlight
constexpr double kDepthCue = 0.28;      // share of the background in the farthest colours
constexpr int kDiscSides = 24;

/// Something to paint, in picture units until the page is fitted.
struct Item {
  enum class Kind : std::uint8_t { Line, Face, Sphere, Circle, Text };
  Kind kind = Kind::Face;
  double depth = 0.0;
  std::uint32_t firstPoint = 0;  // into Picture::points
  std::uint32_t pointCount = 0;
  double startWidth =
      0.0;  // lines: picture units, or pixels when the line style is pixel; spheres and circles: diameter
  double endWidth = 0.0;
  Colour colour;
  double opacity = 1.0;
  std::uint32_t label = 0;  // texts: index into Scene::labels
};

struct Bounds {
  double left = std::numeric_limits<double>::infinity();
  double right = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
  double top = -std::numeric_limits<double>::infinity();
  void include(double x, double y, double radius) {
    left = std::min(left, x - radius);
    right = std::max(right, x + radius);
    bottom = std::min(bottom, y - radius);
    top = std::max(top, y + radius);
  }
};

class Picture {
 public:
  Picture(const Scene& scene, const language::ViewSettings& view, const SvgOptions& options)
      : scene_(scene), view_(view), projection_(view), palette_(scene, options.palette) {
    light_ = core::normalised(-0.45 * projection_.right() + 0.75 * projection_.up() + 0.6 * projection_.towardViewer());
  }

  void collect() {
    chooseProjection();
    addSegments();
    addPolygons();
    addBalls();
    addMeshes();
    addLabels();
    // far to near; equal depths keep the order of drawing
    std::stable_sort(items_.begin(), items_.end(), [](const Item& a, const Item& b) { return a.depth > b.depth; });
  }
  void write(const SvgOptions& options, TextOutput& out);

 private:
  [[nodiscard]] bool hasPixelLines() const { return scene_.lineStyle == language::LineStyle::Pixel; }

  // a perspective whose viewer stands inside the scene shows nothing sensible: draw it in parallel
  void chooseProjection() {
    const bool isClear = std::all_of(scene_.segments.begin(), scene_.segments.end(), [&](const Segment& s) {
      return projection_.isVisible(s.start) && projection_.isVisible(s.end);
    });
    if (!isClear) {
      projection_.useParallel();
    }
  }

  std::uint32_t addPoint(const ProjectedPoint& p, double radius) {
    points_.push_back({p.x, p.y});
    bounds_.include(p.x, p.y, radius);
    nearest_ = std::min(nearest_, p.depth);
    farthest_ = std::max(farthest_, p.depth);
    return static_cast<std::uint32_t>(points_.size() - 1);
  }

  void addSegments() {
    for (const Segment& segment : scene_.segments) {
      const ProjectedPoint a = projection_.project(segment.start);
      const ProjectedPoint b = projection_.project(segment.end);
      Item item;
      item.kind = Item::Kind::Line;
      item.depth = (a.depth + b.depth) / 2.0;
      item.startWidth = segment.startWidth * (hasPixelLines() ? 1.0 : a.magnification);
      item.endWidth = segment.endWidth * (hasPixelLines() ? 1.0 : b.magnification);
      item.firstPoint = addPoint(a, hasPixelLines() ? 0.0 : item.startWidth / 2.0);
      static_cast<void>(addPoint(b, hasPixelLines() ? 0.0 : item.endWidth / 2.0));
      item.pointCount = 2;
      // a branch across the light is brightest
      const Vec3 direction = core::normalised(segment.end - segment.start);
      const double across = std::sqrt(std::max(0.0, 1.0 - core::dot(direction, light_) * core::dot(direction, light_)));
      item.colour = lit(palette_.ofSegment(segment), 0.82 + 0.18 * across);
      item.opacity = palette_.opacityOfIndex(segment.colour);
      items_.push_back(item);
    }
  }

  void addFace(const std::vector<Vec3>& corners, const Vec3& normal, std::int32_t colour) {
    Item item;
    item.kind = Item::Kind::Face;
    item.firstPoint = static_cast<std::uint32_t>(points_.size());
    item.pointCount = static_cast<std::uint32_t>(corners.size());
    for (const Vec3& corner : corners) {
      const ProjectedPoint p = projection_.project(corner);
      static_cast<void>(addPoint(p, 0.0));
      item.depth += p.depth / static_cast<double>(corners.size());
    }
    item.opacity = palette_.opacityOfIndex(colour);
    item.colour = lit(palette_.ofIndex(colour), 0.68 + 0.36 * std::abs(core::dot(normal, light_)));
    items_.push_back(item);
  }

  void addPolygons() {
    for (const Polygon& polygon : scene_.polygons) {
      // Newell's normal serves polygons that are not quite plane
      Vec3 normal;
      for (std::size_t i = 0; i < polygon.vertices.size(); ++i) {
        normal = normal + core::cross(polygon.vertices[i], polygon.vertices[(i + 1) % polygon.vertices.size()]);
      }
      addFace(polygon.vertices, core::normalised(normal), polygon.colour);
    }
  }

  void addBalls() {
    for (const Ball& ball : scene_.balls) {
      if (ball.kind == Ball::Kind::Disc) {
        mesh_.clear();
        appendDisc(mesh_, ball, kDiscSides);
        addFace({mesh_.positions.begin() + 1, mesh_.positions.end() - 1}, ball.frame.up, ball.colour);
        continue;
      }
      const ProjectedPoint p = projection_.project(ball.centre);
      Item item;
      item.kind = ball.kind == Ball::Kind::Sphere ? Item::Kind::Sphere : Item::Kind::Circle;
      // a ball hides the line that ends in it
      item.depth = p.depth - ball.diameter / 2.0;
      item.startWidth = ball.diameter * p.magnification;
      item.firstPoint = addPoint(p, item.startWidth / 2.0);
      item.pointCount = 1;
      item.colour = palette_.ofIndex(ball.colour);
      item.opacity = palette_.opacityOfIndex(ball.colour);
      items_.push_back(item);
    }
  }

  void addMesh(std::int32_t colour) {
    std::vector<Vec3> corners;
    for (const auto& face : mesh_.faces) {
      corners.clear();
      Vec3 normal;
      for (const std::uint32_t vertex : face) {
        if (vertex != Mesh::kNoVertex) {
          corners.push_back(mesh_.positions[vertex]);
          normal = normal + mesh_.normals[vertex];
        }
      }
      addFace(corners, core::normalised(normal), colour);
    }
  }

  void addMeshes() {
    for (const SurfaceInstance& surface : scene_.surfaces) {
      mesh_.clear();
      appendSurface(mesh_, surface, view_);
      addMesh(surface.colour);
    }
    for (const Patch& patch : scene_.patches) {
      mesh_.clear();
      appendPatch(mesh_, patch.points, patch.subdivisionS, patch.subdivisionT);
      addMesh(patch.colour);
    }
    for (const GeneralizedCylinder& cylinder : scene_.cylinders) {
      mesh_.clear();
      appendCylinder(mesh_, cylinder, view_);
      addMesh(cylinder.points.front().colour);
    }
  }

  void addLabels() {
    for (std::size_t i = 0; i < scene_.labels.size(); ++i) {
      const ProjectedPoint p = projection_.project(scene_.labels[i].position);
      Item item;
      item.kind = Item::Kind::Text;
      // text is for reading: before everything else
      item.depth = -std::numeric_limits<double>::infinity();
      item.firstPoint = addPoint(p, 0.0);
      item.pointCount = 1;
      item.colour = palette_.ofIndex(scene_.labels[i].colour);
      item.label = static_cast<std::uint32_t>(i);
      items_.push_back(item);
    }
  }

  [[nodiscard]] static Colour lit(const Colour& colour, double factor) {
    return factor <= 1.0 ? mixed(Colour{22, 26, 30}, colour, factor)
                         : mixed(colour, Colour{255, 255, 250}, factor - 1.0);
  }
  [[nodiscard]] Colour withDepth(const Item& item) const {
    const double range = farthest_ - nearest_;
    const double width = std::max(bounds_.right - bounds_.left, bounds_.top - bounds_.bottom);
    // a flat scene has no depth worth showing
    const double strength = width > 0.0 ? kDepthCue * std::min(1.0, range / width) : 0.0;
    const double t = range > 0.0 ? (item.depth - nearest_) / range : 0.0;
    return mixed(item.colour, palette_.background(), strength * std::clamp(t, 0.0, 1.0));
  }

  void writeItem(const Item& item, TextOutput& out);
  void writeLine(const Item& item, const Colour& colour, TextOutput& out);
  void writeCapsule(double x0, double y0, double r0, double x1, double y1, double r1, const Colour& colour,
                    TextOutput& out);
  void writeGradients(TextOutput& out);

  [[nodiscard]] double pageX(const Item& item, std::uint32_t k) const {
    return offsetX_ + points_[item.firstPoint + k][0] * scale_;
  }
  [[nodiscard]] double pageY(const Item& item, std::uint32_t k) const {
    return offsetY_ - points_[item.firstPoint + k][1] * scale_;
  }

  const Scene& scene_;
  const language::ViewSettings& view_;
  Projection projection_;
  Palette palette_;
  Vec3 light_;  // toward the light
  Mesh mesh_;
  std::vector<std::array<double, 2>> points_;
  std::vector<Item> items_;
  Bounds bounds_;
  double nearest_ = std::numeric_limits<double>::infinity();
  double farthest_ = -std::numeric_limits<double>::infinity();
  double scale_ = 1.0;  // pixels per picture unit
  double offsetX_ = 0.0;
  double offsetY_ = 0.0;
};

void writeHex(const Colour& colour, TextOutput& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  out << '#';
  for (const unsigned char channel : {colour.red, colour.green, colour.blue}) {
    out << kDigits[channel >> 4U] << kDigits[channel & 15U];
  }
}

std::string gradientName(const Colour& colour) {
  core::StringSink sink;
  {
    TextOutput out(sink);
    writeHex(colour, out);
  }
  return "s" + sink.text().substr(1);
}

void writeEscaped(std::string_view text, TextOutput& out) {
  for (const char c : text) {
    switch (c) {
      case '<':
        out << "&lt;";
        break;
      case '>':
        out << "&gt;";
        break;
      case '&':
        out << "&amp;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 32) {
          out << c;
        }
    }
  }
}

void Picture::writeCapsule(double x0, double y0, double r0, double x1, double y1, double r1, const Colour& colour,
                           TextOutput& out) {
  const double dx = x1 - x0;
  const double dy = y1 - y0;
  const double l = std::hypot(dx, dy);
  if (l < 1e-6) {
    out << "<circle cx=\"";
    out.number(x0, 2) << "\" cy=\"";
    out.number(y0, 2) << "\" r=\"";
    out.number(std::max(r0, r1), 2) << "\" fill=\"";
    writeHex(colour, out);
    out << "\"/>\n";
    return;
  }
  // two sides and a round cap at each end
  const double nx = dy / l;
  const double ny = -dx / l;
  const auto point = [&](double x, double y) {
    out.number(x, 2) << ' ';
    out.number(y, 2);
  };
  const auto arc = [&](double r) {
    out << 'A';
    out.number(r, 2) << ' ';
    out.number(r, 2) << " 0 0 1 ";
  };
  out << "<path d=\"M";
  point(x0 + nx * r0, y0 + ny * r0);
  out << 'L';
  point(x1 + nx * r1, y1 + ny * r1);
  arc(r1);
  point(x1 - nx * r1, y1 - ny * r1);
  out << 'L';
  point(x0 - nx * r0, y0 - ny * r0);
  arc(r0);
  point(x0 + nx * r0, y0 + ny * r0);
  out << "Z\" fill=\"";
  writeHex(colour, out);
  out << "\"/>\n";
}

void Picture::writeLine(const Item& item, const Colour& colour, TextOutput& out) {
  const double unit = hasPixelLines() ? 1.0 : scale_;
  const double r0 = std::max(item.startWidth * unit, kThinnestLine) / 2.0;
  const double r1 = std::max(item.endWidth * unit, kThinnestLine) / 2.0;
  const double x0 = pageX(item, 0);
  const double y0 = pageY(item, 0);
  const double x1 = pageX(item, 1);
  const double y1 = pageY(item, 1);
  writeCapsule(x0, y0, r0, x1, y1, r1, colour, out);
  if (r0 + r1 >= kHighlightFrom) {
    // the lit flank: a narrower, lighter line toward the upper left
    const double shift = 0.32;
    writeCapsule(x0 - shift * r0 * 0.8, y0 - shift * r0 * 0.6, r0 * 0.45, x1 - shift * r1 * 0.8, y1 - shift * r1 * 0.6,
                 r1 * 0.45, mixed(colour, {255, 250, 235}, 0.16), out);
  }
}

void Picture::writeItem(const Item& item, TextOutput& out) {
  const Colour colour = withDepth(item);
  switch (item.kind) {
    case Item::Kind::Line:
      writeLine(item, colour, out);
      return;
    case Item::Kind::Face:
      out << "<path d=\"";
      for (std::uint32_t k = 0; k < item.pointCount; ++k) {
        out << (k == 0 ? 'M' : 'L');
        out.number(pageX(item, k), 2) << ' ';
        out.number(pageY(item, k), 2);
      }
      // a hairline of the same colour closes the seams between neighbours
      out << "Z\" fill=\"";
      writeHex(colour, out);
      out << "\" stroke=\"";
      writeHex(colour, out);
      out << "\" stroke-width=\"0.4\"/>\n";
      return;
    case Item::Kind::Sphere:
    case Item::Kind::Circle:
      out << "<circle cx=\"";
      out.number(pageX(item, 0), 2) << "\" cy=\"";
      out.number(pageY(item, 0), 2) << "\" r=\"";
      out.number(std::max(item.startWidth * scale_, kThinnestLine) / 2.0, 2) << "\" fill=\"";
      if (item.kind == Item::Kind::Sphere) {
        out << "url(#" << gradientName(item.colour) << ")";
      } else {
        writeHex(colour, out);
      }
      out << "\"/>\n";
      return;
    case Item::Kind::Text:
      out << "<text x=\"";
      out.number(pageX(item, 0), 2) << "\" y=\"";
      out.number(pageY(item, 0), 2) << "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"";
      writeHex(item.colour, out);
      out << "\">";
      writeEscaped(scene_.labels[item.label].text, out);
      out << "</text>\n";
      return;
  }
}

void Picture::writeGradients(TextOutput& out) {
  std::set<std::string> written;
  for (const Item& item : items_) {
    if (item.kind != Item::Kind::Sphere || !written.insert(gradientName(item.colour)).second) {
      continue;
    }
    out << "<radialGradient id=\"" << gradientName(item.colour)
        << "\" cx=\"0.38\" cy=\"0.32\" r=\"0.75\"><stop offset=\"0\" "
        << "stop-color=\"";
    writeHex(mixed(item.colour, {255, 252, 240}, 0.45), out);
    out << "\"/><stop offset=\"0.55\" stop-color=\"";
    writeHex(item.colour, out);
    out << "\"/><stop offset=\"1\" stop-color=\"";
    writeHex(mixed(item.colour, {22, 26, 30}, 0.42), out);
    out << "\"/></radialGradient>\n";
  }
}

void Picture::write(const SvgOptions& options, TextOutput& out) {
  // fit the bounds to the page
  const double marginX = options.widthPixels * options.marginFraction;
  const double marginY = options.heightPixels * options.marginFraction;
  const double width = items_.empty() ? 0.0 : bounds_.right - bounds_.left;
  const double height = items_.empty() ? 0.0 : bounds_.top - bounds_.bottom;
  const double scaleX = width > 0.0 ? (options.widthPixels - 2.0 * marginX) / width : 1e300;
  const double scaleY = height > 0.0 ? (options.heightPixels - 2.0 * marginY) / height : 1e300;
  scale_ = std::min(scaleX, scaleY) < 1e300 ? std::min(scaleX, scaleY) : 1.0;
  if (!items_.empty()) {
    offsetX_ = options.widthPixels / 2.0 - scale_ * (bounds_.left + bounds_.right) / 2.0;
    offsetY_ = options.heightPixels / 2.0 + scale_ * (bounds_.bottom + bounds_.top) / 2.0;
  }
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" "
         "width=\"";
  out.number(options.widthPixels, 2) << "\" height=\"";
  out.number(options.heightPixels, 2) << "\" viewBox=\"0 0 ";
  out.number(options.widthPixels, 2) << ' ';
  out.number(options.heightPixels, 2) << "\">\n";
  writeGradients(out);
  if (options.hasBackground) {
    out << "<rect width=\"100%\" height=\"100%\" fill=\"";
    writeHex(palette_.background(), out);
    out << "\"/>\n";
  }
  for (const Item& item : items_) {
    if (item.opacity < 1.0) {
      out << "<g opacity=\"";
      out.number(item.opacity, 3) << "\">\n";
    }
    writeItem(item, out);
    if (item.opacity < 1.0) {
      out << "</g>\n";
    }
  }
  out << "</svg>\n";
}

}  // namespace

void writeSvg(const Scene& scene, const language::ViewSettings& view, const SvgOptions& options, core::ByteSink& sink) {
  Picture picture(scene, view, options);
  picture.collect();
  TextOutput out(sink);
  picture.write(options, out);
}

}  // namespace espalier::turtle
