#pragma once

#include "engine/core/streams.h"
#include "engine/language/colour_files.h"
#include "engine/language/view_settings.h"
#include "engine/turtle/scene.h"

namespace espalier::turtle {

/// RGB of a colour index, each 0..255.
struct Colour {
  unsigned char red = 0, green = 0, blue = 0;
};

/// The colour of an index without a palette: Espalier's own readable botanical ramp.
[[nodiscard]] Colour defaultColour(std::int32_t index);

struct SvgOptions {
  double widthPixels = 800.0;
  double heightPixels = 800.0;
  double marginFraction = 0.05;
  bool hasBackground = true;
  const language::Palette* palette =
      nullptr;  // a model folder's colours, its background too; null or empty: Espalier's own
};

/// Writes a picture of the scene as SVG 1.1: parallel or perspective view of the view settings, far to near, tapered
/// branches as polygons, fitted to the picture with the margin. Deterministic text. O(n log n).
void writeSvg(const Scene& scene, const language::ViewSettings& view, const SvgOptions& options, core::ByteSink& sink);

/// Writes a Wavefront OBJ: an `o` per organ kind and plant, tubes swept along connected segments with normals and
/// texture coordinates, polygons, spheres, surfaces; materials go to a companion .mtl, in the colours of `palette`
/// unless it is null or empty.
void writeObj(const Scene& scene, const language::ViewSettings& view, const std::string& materialFile,
              core::ByteSink& object, core::ByteSink& materials, const language::Palette* palette = nullptr);

}  // namespace espalier::turtle
