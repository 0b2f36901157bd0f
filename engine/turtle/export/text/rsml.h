#pragma once

#include <optional>
#include <string>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes the lines of the plants in the Root System Markup Language (Lobet et al., Plant Physiology 167, 2015): a
/// plant for each plant, an axis as a polyline with the function `diameter`, laterals inside of the axis from which
/// they grow, with the property `parent-node` (from 0). Lengths are in world units; the unit is not known to the scene.
/// Coordinates have twelve digits of the largest. The step of the string, where it is known, is the `index` of a
/// `time-sequence`; axes get their numbers anew in each step, so the sequence is not `unified`.
[[nodiscard]] std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target);

}  // namespace espalier::turtle
