#pragma once

#include <optional>

#include "engine/core/streams.h"
#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

struct PostScriptOptions {
  double widthPoints = 540.0;  // of the box that the drawing is fitted into; a point is 1/72 inch
  double heightPoints = 720.0;
  const files::Palette* palette = nullptr;  // a model folder's colours; null or empty: Espalier's own
  std::optional<PictureFrame> frame = {};   // the extent of the drawing; nothing: that of the scene
};

/// Writes a drawing as Encapsulated PostScript, level 2, one page: lines by branch order, then organs from far to near,
/// then labels; no background, no opacity (PostScript has none). Line ends as the view file's `PS linecap` says.
/// Deterministic text.
void writePostScript(const Scene& scene, const files::ViewSettings& view, const PostScriptOptions& options,
                     core::ByteSink& sink);

}  // namespace espalier::turtle
