#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes VTK poly data (.vtp, XML 1.0 with inline base64, little-endian), as ParaView and the VTK library read it.
/// Points have normals; cells have `plant`, `module` (index in the plant's string), `symbol` (a number; the field data
/// `symbols` names them), `order` (of the branch), `age` (steps since the module came; NaN: not known), `organ` (the
/// number of an OrganKind), `colour` (red, green, blue) and `parameter1` to `parameter4` of the module (NaN where it
/// has fewer). The file is a list of pieces, so each mesh is made once and memory does not grow with the scene.
[[nodiscard]] std::optional<std::string> exportVtp(const PlacedScenes& placed, const ExportTarget& target);

/// Writes the same as a VTK unstructured grid (.vtu): its cells are triangles and quads with the same data. Programs of
/// finite elements and filters of volumes ask for this kind.
[[nodiscard]] std::optional<std::string> exportVtu(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
