#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// What the file of a root system says beside the lines that its model draws.
struct RsmlLabels {
  struct Plant {
    std::string id, label;  // empty: none
  };
  struct Root {
    std::string id, label;    // empty: none
    std::uint32_t plant = 0;  // index of plants
    // of its first point; not a number: unknown
    double firstDiameter = std::numeric_limits<double>::quiet_NaN();
    double firstDay = std::numeric_limits<double>::quiet_NaN();
  };
  struct Piece {
    std::uint32_t root = 0;                                 // index of roots
    std::uint64_t step = 0;                                 // from which on it is drawn
    double day = std::numeric_limits<double>::quiet_NaN();  // of emergence; not a number: unknown
  };
  std::vector<Plant> plants;
  std::vector<Root> roots;
  std::vector<Piece> pieces;  // lines in the order in which they are drawn
};

/// Writes the lines of the plants in the Root System Markup Language (Lobet et al., Plant Physiology 167, 2015): a
/// plant for each plant, an axis as a polyline with the function `diameter`, laterals inside of the axis from which
/// they grow, with the property `parent-node` (from 0). Lengths have the unit of the input, or `unknown`.
/// Coordinates have twelve digits of the largest. The step of the string, where it is known, is the `index` of a
/// `time-sequence`; axes get their numbers anew in each step, so the sequence is not `unified`. Last points without a
/// width have no sample. With ExportInput::rsml, and as many lines as it has pieces in the step, plants and roots have
/// their names, and days of emergence are those of the labels.
[[nodiscard]] std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target);

/// Writes one file of all steps: the axes of the last step with the function `emergence_time`, the day of the first
/// step in which a line ends at a point. Roots stay where they grew, so this is their growth; of a plant that moves it
/// is when its last places were reached. Lines that are gone at the end are not in the file.
[[nodiscard]] std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& range);

}  // namespace espalier::turtle
