#pragma once

#include <optional>
#include <string>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes the lines of the plants in the Root System Markup Language (Lobet et al., Plant Physiology 167, 2015): a
/// plant for each plant, an axis as a polyline with the function `diameter`, laterals inside of the axis from which
/// they grow, with the property `parent-node` (from 0). Lengths are in world units; the unit is not known to the scene.
[[nodiscard]] std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target);

}  // namespace espalier::turtle
