#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes a Wavefront OBJ: an `o` per organ kind and plant, tubes swept along connected segments with normals and
/// texture coordinates, polygons, spheres, surfaces; materials go to a companion .mtl.
[[nodiscard]] std::optional<std::string> exportObj(const ExportInput& input, const ExportTarget& target);

}  // namespace espalier::turtle
