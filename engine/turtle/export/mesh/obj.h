#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes a Wavefront OBJ: an `o` per organ kind and plant, tubes swept along connected segments with normals and
/// texture coordinates, polygons, spheres, surfaces; materials go to a companion .mtl, and each texture that is worn to
/// a companion NAME_texture_1.png (or .jpg) that it names. Copies of scenes are written out one after the other.
[[nodiscard]] std::optional<std::string> exportObj(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
