#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// The content of a root system's file: its plants and roots as they are in it, and which lines of its model draw them.
struct RsmlLabels {
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Plant {
    std::string id, label;  // empty: none
  };
  struct Point {
    core::Vec3 place;
    double diameter = std::numeric_limits<double>::quiet_NaN();  // not a number: unknown
    double day = std::numeric_limits<double>::quiet_NaN();       // of emergence; not a number: unknown
    std::uint64_t step = 0;  // from which on it is there; never decreases along a root
  };
  struct Root {
    std::string id, label;         // empty: none
    std::uint32_t plant = 0;       // index of plants
    std::uint32_t parent = kNone;  // an earlier root that it is a lateral of; kNone: it is none
    std::size_t parentNode = 0;    // point of the parent at which it begins
    std::vector<Point> points;     // empty: the file gives none
  };
  struct Piece {
    std::uint32_t root = 0;  // index of roots
    std::size_t point = 0;   // of that root, at which the line ends
  };
  std::vector<Plant> plants;
  std::vector<Root> roots;
  std::vector<Piece> pieces;  // lines in the order in which they are drawn
};

/// Writes the lines of the plants in the Root System Markup Language (Lobet et al., Plant Physiology 167, 2015): a
/// plant for each plant, an axis as a polyline with the function `diameter`, laterals inside of the axis from which
/// they grow, with the property `parent-node` (from 0). Lengths have the unit of the input, or `unknown`.
/// Coordinates have twelve digits of the largest, or fourteen where the plants are small beside their distance from the
/// origin. The step of the string, where it is known, is the `index` of a `time-sequence`; axes get their numbers anew
/// in each step, so the sequence is not `unified`. Last points without a width have no sample. With ExportInput::rsml,
/// and the lines of it that are drawn in the step, the file has the roots of the labels instead: their order,
/// hierarchy, names and numbers.
[[nodiscard]] std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target);

/// Writes one file of all steps: the axes of the last step with the function `emergence_time`, the day of the first
/// step in which a line ends at a point. Roots stay where they grew, so this is their growth; of a plant that moves it
/// is when its last places were reached. Lines that are gone at the end are not in the file.
[[nodiscard]] std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& range);

}  // namespace espalier::turtle
