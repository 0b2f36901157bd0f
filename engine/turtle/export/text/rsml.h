#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes the lines of the plants in the Root System Markup Language (Lobet et al., Plant Physiology 167, 2015): a
/// plant for each plant, an axis as a polyline with the function `diameter`, laterals inside of the axis from which
/// they grow, with the property `parent-node` (from 0). Lengths have the unit of the input, or `unknown`.
/// Coordinates have twelve digits of the largest. The step of the string, where it is known, is the `index` of a
/// `time-sequence`; axes get their numbers anew in each step, so the sequence is not `unified`.
[[nodiscard]] std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target);

/// Writes one file of all steps: the axes of the last step with the function `emergence_time`, the day of the first
/// step in which a line ends at a point. Roots stay where they grew, so this is their growth; of a plant that moves it
/// is when its last places were reached. Lines that are gone at the end are not in the file.
[[nodiscard]] std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& range);

}  // namespace espalier::turtle
