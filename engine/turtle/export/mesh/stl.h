#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes a binary STL: triangles with the normal of their side, for printing and for programs that read nothing else.
/// Triangles without area are left out. Makes each mesh twice: to count and to write.
[[nodiscard]] std::optional<std::string> exportStl(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
