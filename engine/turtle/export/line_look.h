#pragma once

#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// How pictures and meshes draw lines. Nothing else uses it: strings, tables and environments have the model's widths.
///
/// A model whose view file gives neither a line style nor a width says nothing about widths in space. Its lines are
/// round then, and as thick as a plant of that size looks right: the thickest is a fixed part of the extent, thinner
/// where lines are short, so that dense drawings stay clear. Widths that the model itself sets keep their proportions;
/// where it sets none, side branches are thinner than what they grow on.
struct LineLook {
  files::LineStyle style = files::LineStyle::Pixel;
  double unit = 1.0;          // world units, or pixels in that style, of one unit of the model's widths
  bool thinsByOrder = false;  // the model sets no widths

  [[nodiscard]] double startWidth(const Segment& segment) const { return widthOf(segment, segment.startWidth); }
  [[nodiscard]] double endWidth(const Segment& segment) const { return widthOf(segment, segment.endWidth); }

 private:
  [[nodiscard]] double widthOf(const Segment& segment, double width) const;
};

/// For pictures. O(segments).
[[nodiscard]] LineLook lineLookOf(const Scene& scene, const files::ViewSettings& view);

/// For meshes: never in pixels. They have no size in the world, so that one is a fixed part of the scene's extent.
[[nodiscard]] LineLook meshLineLookOf(const Scene& scene, const files::ViewSettings& view);

}  // namespace espalier::turtle
