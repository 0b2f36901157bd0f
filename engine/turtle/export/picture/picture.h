#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "engine/files/colour_files.h"
#include "engine/files/images/image_file.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// The background of a picture.
enum class PictureBackground : std::uint8_t { Model, White, Transparent };  // Model: Palette::background()

/// Which part of the scene a picture shows. Both look from the view file's viewpoint, in its projection.
enum class PictureFraming : std::uint8_t {
  Fitted,  // everything drawn, as large as the page allows
  View,    // as in the view file: `box`, `scale factor`, `viewing angle`
};

struct PictureOptions;
using PictureImage = files::Image;

/// Draws copies of scenes; returns a sentence when it cannot.
using PictureDrawer = std::function<std::optional<std::string>(
    const PlacedScenes& placed, const PictureOptions& options, PictureImage& image, const ExportProgress& progress)>;

/// How a picture of points is made.
struct PictureOptions {
  int widthPixels = 800;
  int heightPixels = 600;
  double marginFraction = 0.05;  // of a fitted picture, at each edge
  PictureBackground background = PictureBackground::Model;
  PictureFraming framing = PictureFraming::Fitted;
  std::optional<PictureFrame> frame = {};   // the extent that a fitted picture shows; nothing: its own
  std::uint64_t sampleBytes = 320'000'000;  // memory for samples; a larger picture is made in strips, with more time
  unsigned threads = 1;                     // the picture does not depend on them
  int maximumColours = 0;                   // 2 to 256: of the file; 0: as many as there are
  bool hasGround = true;                    // shade where plants stand, on a fitted page of the model
  const files::Palette* palette = nullptr;  // a model folder's colours; null or empty: Espalier's own
  PictureDrawer draw = {};                  // makes the picture of a file; empty: renderPlaced()
};

/// Largest width and height of a picture.
inline constexpr int kMaximumPicturePixels = 16'384;

/// Renders a scene: triangles with depth, shaded by the view file's lights, or by Espalier's own (a key light from the
/// upper left, a weaker one from the right, light from the sky); lines in the view file's style; 16 samples a pixel.
/// Needs 128 bytes for each pixel of a strip (PictureOptions::sampleBytes) and little more, whatever the size of the
/// scene.
[[nodiscard]] PictureImage renderPicture(const Scene& scene, const files::ViewSettings& view,
                                         const PictureOptions& options);

/// The same for copies of scenes. Colours are those of each scene's own palette, not of the options.
[[nodiscard]] PictureImage renderPlaced(const PlacedScenes& placed, const PictureOptions& options,
                                        const ExportProgress& progress = {});

/// The extent that a fitted picture of these scenes shows.
[[nodiscard]] PictureFrame pictureFrame(const PlacedScenes& placed, const PictureOptions& options);

}  // namespace espalier::turtle
