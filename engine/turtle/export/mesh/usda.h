#pragma once

#include <memory>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes the scene as a USD stage in text: a mesh for each plant and material (in pieces of about a hundred thousand
/// vertices), with normals, texture coordinates `st`, colours and preview materials; y is up.
[[nodiscard]] std::optional<std::string> exportUsda(const PlacedScenes& placed, const ExportTarget& target);

/// A stage of a growing plant: each frame's meshes stand below an Xform `step_N` whose visibility is sampled in time,
/// so that one frame after another can be written. One time code is one step.
[[nodiscard]] std::unique_ptr<GrowthExport> beginUsdaGrowth(const ExportTarget& target, const GrowthRange& range);

}  // namespace espalier::turtle
