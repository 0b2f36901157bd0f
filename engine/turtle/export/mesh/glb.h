#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes binary glTF 2.0: a node for each plant, below it a node for each kind of organs (branches, leaves, fruits)
/// with one mesh, a primitive for each material (in pieces of about a million vertices). With
/// ExportInput::usesInstancing surfaces, spheres and discs are a node for each shape, material and plant
/// (EXT_mesh_gpu_instancing), for a small file. Normals, texture coordinates (u around a branch, v along it in length
/// units), materials in the colours of the palette, named by their use; y is up, right-handed, one unit is one length
/// unit. Fails when the file would exceed the format's 4 GiB or a number does not fit 32 bits. Makes each mesh twice:
/// once to count, once to write.
[[nodiscard]] std::optional<std::string> exportGlb(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
