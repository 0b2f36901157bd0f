#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/line_look.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_shading.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// A point of a page, in its units from the upper left corner.
struct PagePlace {
  double x = 0.0;
  double y = 0.0;
};

/// All lines of one branch order, colour and opacity.
struct PageLines {
  std::uint32_t order = 0;
  Colour colour;
  double opacity = 1.0;
  double width = 0.0;                   // of every line, page units; 0: lines differ, or taper
  std::vector<std::uint32_t> segments;  // indices into Scene::segments, in order of drawing
};

/// An organ, or a face of one.
struct PageShape {
  enum class Kind : std::uint8_t { Face, Sphere, Disc, Text };
  Kind kind = Kind::Face;
  double depth = 0.0;
  std::uint32_t firstPoint = 0;
  std::uint32_t pointCount = 0;
  double radius = 0.0;  // of spheres and discs, page units
  Colour colour;        // as lit
  double opacity = 1.0;
  std::uint32_t label = 0;  // of texts, an index into Scene::labels
};

/// A scene as drawn on paper, for the formats of lines and areas: the view file's projection, fitted to a page; all
/// lines by branch order, then organs from far to near, then text. A shape with a texture has its mean colour: a line
/// of all of it, a face of an organ of its own part, and a face mostly over a hole is left out. Holds 4 bytes for a
/// line and the corners of organs.
class PageDrawing {
 public:
  /// `scene` and `palette` must outlive the object. The page is at most `width` by `height` and as small as the drawing
  /// with a margin of `marginFraction` of the larger side allows; with a `frame` that is what there is room for.
  PageDrawing(const Scene& scene, const files::ViewSettings& view, const Palette& palette, double width, double height,
              double marginFraction, const std::optional<PictureFrame>& frame = {});

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] double height() const { return height_; }
  /// By order; of one order in order of drawing.
  [[nodiscard]] std::span<const PageLines> lines() const { return lines_; }
  [[nodiscard]] std::span<const PageShape> shapes() const { return shapes_; }
  [[nodiscard]] PagePlace point(const PageShape& shape, std::uint32_t corner) const;
  [[nodiscard]] PagePlace place(const core::Vec3& position) const;
  /// Half the width of a segment at its start or end, page units, at least a quarter of one.
  [[nodiscard]] double radius(const Segment& segment, bool isEnd) const;

 private:
  void chooseProjection();
  void addFace(std::span<const core::Vec3> corners, const core::Vec3& normal, std::int32_t colour);
  void addFace(std::span<const core::Vec3> corners, const core::Vec3& normal, const Colour& colour, double opacity);
  void addMesh(const Mesh& mesh, std::int32_t colour, std::int32_t texture);
  void addShapes();
  void addLines();
  void fit(double width, double height, double marginFraction);
  [[nodiscard]] bool hasPixelLines() const { return look_.style == files::LineStyle::Pixel; }

  const Scene& scene_;
  const files::ViewSettings& view_;
  const Palette& palette_;
  LineLook look_;
  Projection projection_;
  RasterTextures textures_;
  core::Vec3 light_;  // toward the light
  PictureBounds bounds_;
  std::vector<std::array<double, 2>> points_;  // picture units
  std::vector<PageLines> lines_;
  std::vector<PageShape> shapes_;
  double scale_ = 1.0;  // page units per picture unit
  double offsetX_ = 0.0;
  double offsetY_ = 0.0;
  double width_ = 0.0;
  double height_ = 0.0;
};

}  // namespace espalier::turtle
