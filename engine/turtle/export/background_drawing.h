#pragma once

#include "engine/files/colour_files.h"
#include "engine/files/surfaces/background_scene.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// A background scene (docs/model-files.md, 11.4) as a scene of its own, with its materials as palette: exporters of
/// placed scenes write it behind the scene of the plants. Spheres are balls; the triangles of each material are one
/// surface, smooth where they meet at less than 40 degrees. O(corners).
class BackgroundDrawing {
 public:
  explicit BackgroundDrawing(const files::BackgroundScene& background);

  /// To be exported beside the plants of `model`, with its camera, level of detail and threads. Refers to the object.
  [[nodiscard]] ExportInput input(const ExportInput& model) const;

 private:
  Scene scene_;
  files::ViewSettings view_;
  files::Palette palette_;
};

}  // namespace espalier::turtle
