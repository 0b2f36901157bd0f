#pragma once

#include <optional>
#include <string>

#include "engine/files/view_settings.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/picture/picture.h"

namespace espalier::command {

/// How `--render` makes a picture. Angles in degrees.
struct RenderOptions {
  bool isOn = false;
  int samples = 512;             // of a pixel, at most
  double noise = 0.008;          // standard error of a tile's brightness, as a share of white, at which it is done
  double sunElevation = 58.0;    // above the horizon
  double sunAzimuth = -35.0;     // from the direction to the viewer toward the right of the page
  std::optional<double> height;  // of the viewer above the horizon; nothing: the view file's, at least 8
  double turn = 0.0;             // of the viewer about the plant, counter-clockwise seen from above
};

/// The view file's camera as it renders: a viewer who would look along the ground is raised above it and turned.
[[nodiscard]] files::ViewSettings viewToRender(const files::ViewSettings& view, const RenderOptions& render);

/// Draws copies of scenes in the light of sun and sky: soft shadows, light that leaves throw on others and let through,
/// textures, and a ground as bright as the page, on which shadows fall. Camera, extent and page are those of
/// renderPlaced(). The ground is there when plants stand (groundContactsOf). Lines are round. Text is not drawn.
///
/// Tiles of 16 by 16 pixels get rounds of samples until their noise is small. The picture does not depend on the
/// threads. Returns a sentence when the scene cannot be rendered.
[[nodiscard]] std::optional<std::string> renderInDaylight(const turtle::PlacedScenes& placed,
                                                          const turtle::PictureOptions& options,
                                                          const RenderOptions& render, turtle::PictureImage& image,
                                                          const turtle::ExportProgress& progress = {});

}  // namespace espalier::command
