#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes binary glTF 2.0: a node for each plant, below it a mesh for each of its materials (in pieces of about a
/// million vertices), and nodes for surfaces, spheres and discs, which share one mesh for each shape and material. Each
/// node of an organ has the index of its module in `extras`. Normals, texture coordinates (u around a branch, v along
/// it in length units), materials in the colours of the palette; y is up, right-handed, one unit is one length unit.
/// Fails when the file would exceed the format's 4 GiB or a number does not fit 32 bits. Makes each mesh twice: once to
/// count, once to write.
[[nodiscard]] std::optional<std::string> exportGlb(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
