#pragma once

#include <optional>

#include "engine/core/streams.h"
#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

struct SvgOptions {
  double widthPixels = 800.0;
  double heightPixels = 800.0;
  double marginFraction = 0.05;
  bool hasBackground = true;
  const files::Palette* palette =
      nullptr;  // a model folder's colours, its background too; null or empty: Espalier's own
  std::optional<PictureFrame> frame = {};  // the extent of the drawing; nothing: that of the scene
};

/// Writes a drawing of the scene as SVG 1.1 in the view file's projection: one path for each branch order (and colour),
/// with the class `order-N`: strokes when all its lines have one width, else outlines; then organs from far to near,
/// then labels. The viewBox is the drawing with its margin, no larger than asked for. Deterministic text. O(n log n).
void writeSvg(const Scene& scene, const files::ViewSettings& view, const SvgOptions& options, core::ByteSink& sink);

}  // namespace espalier::turtle
