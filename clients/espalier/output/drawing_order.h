#pragma once

#include "engine/files/colour_files.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// Gives the lines of a scene the colours of the order in which they were drawn: red, orange, yellow, green, blue,
/// purple and red again (after the slides of I. Kolingerová). Returns the colours that the new indices mean; polygons
/// and surfaces keep indices that then mean one of these. O(segments).
[[nodiscard]] files::Palette colourByDrawingOrder(turtle::Scene& scene);

}  // namespace espalier::command
