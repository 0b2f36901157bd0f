#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/export/text/rsml.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::roots {

/// Roots, or shoots, as trees of points. An axis is a series of points of one order; a lateral begins at a point of
/// another axis.
struct RootSystem {
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Node {
    std::uint32_t parent = kNone;  // an earlier node; kNone: the collar of a plant
    core::Vec3 place;
    double radius = 0.0;
    std::uint32_t order = 1;  // 1: an axis that begins at a collar
    std::uint32_t axis = 0;   // number of the axis that the segment to the parent belongs to
    bool hasDiameter = true;  // false: the file gives none, and the radius is 0
    double emergence = std::numeric_limits<double>::quiet_NaN();  // day; not a number: unknown
  };
  /// The data of an axis in a file beside its nodes.
  struct Axis {
    std::string id, label;         // empty: none
    std::uint32_t plant = 0;       // index of plants
    std::uint32_t parent = kNone;  // an earlier axis from which it grows; kNone: none
    std::size_t parentNode = 0;    // point of that axis
    bool hasFirstNode = true;      // false: its first point is that of the parent, and has no node of its own
    // of its first point; not a number: unknown
    double firstDiameter = std::numeric_limits<double>::quiet_NaN();
    double firstDay = std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<Node> nodes;
  std::vector<turtle::RsmlLabels::Plant> plants;  // of the file; empty: not known
  std::vector<Axis> axes;                         // by number; empty: not known
  std::string unit;                               // of lengths; empty: unknown
  std::string remark;                             // the parts that could not be read as the file says; empty: none

  /// Whether there is something to draw.
  [[nodiscard]] bool hasLines() const;
};

/// Files with larger coordinates are refused: lengths between them could not be computed.
inline constexpr double kLargestCoordinate = 1e100;

/// Reads the Root System Markup Language (Lobet et al. 2015): axes as polylines, laterals inside their parent, the
/// functions `diameter` and `emergence_time` (or `node_creation_time`) in all domains, the unit of lengths. Points and
/// samples elsewhere, as in annotations, belong to no root. A lateral begins at the point `parent-node`, or else at the
/// nearest point of its parent. An error is a sentence with the line, as for a unit that is unknown or samples that do
/// not fit the points. At most `mostPoints` points and 1000 orders. Memory: about 100 bytes a point beside the text.
inline constexpr std::size_t kMostPoints = 10'000'000;
[[nodiscard]] tl::expected<RootSystem, std::string> readRsml(std::string_view text,
                                                             std::size_t mostPoints = kMostPoints);

/// Reads a table with the columns node, parent, x, y, z and, if there are such, radius, order and emergence, separated
/// by tabs; a parent of −1 makes a collar. Nodes stand in any order. An error is a sentence with the line.
[[nodiscard]] tl::expected<RootSystem, std::string> readRootTable(std::string_view text);

/// One of both by the ending of a file's name: `.rsml`, or a table.
[[nodiscard]] tl::expected<RootSystem, std::string> readRoots(const std::string& fileName, std::string_view text,
                                                              std::size_t mostPoints = kMostPoints);

/// The most points of roots that can be drawn by a model whose source has so many bytes.
[[nodiscard]] constexpr std::size_t mostDrawnPoints(std::size_t sourceBytes) {
  return sourceBytes / 50;
}

/// The lines that plants draw, by the segments that they grow from. A line that grows from none begins at a collar and
/// is of order 1, also inside brackets.
[[nodiscard]] RootSystem rootsOf(const turtle::Scene& scene);

/// A root system as it was on a day.
struct DatedRoots {
  double day = 0.0;
  RootSystem roots;
};

/// One root system of a time series in the order of its days, at least one: the last, in which each point emerged on
/// the first day that has it. The error is a sentence: the units are different. O(points).
[[nodiscard]] tl::expected<RootSystem, std::string> joinSeries(std::vector<DatedRoots> series);

/// Gives all lengths in `unit`. The error is a sentence without the file's name: the size of one of the units, such as
/// a pixel, is not known. Roots without a unit stay as they are.
[[nodiscard]] std::optional<std::string> convertTo(RootSystem& roots, const std::string& unit);

/// Why the days of emergence make no animation: they span more than a million. Nothing: they do, or there are none.
[[nodiscard]] std::optional<std::string> problemOfDays(const RootSystem& roots);

/// Whether the name of a file is that of a root system: `.rsml`, or `.tsv` for a table.
[[nodiscard]] bool isRootFile(std::string_view fileName);

/// The roots as a string of modules that draws them: @M to the collar, then for each segment @R !(diameter) F(length)
/// and a query ?E(age,order,0,0,0,0,0,0,0,0) as `xylem` reads it, laterals in brackets. The age is that at the last
/// emergence of the file; 0 where none is known.
[[nodiscard]] std::string stringOf(const RootSystem& roots);

/// The source of a model that draws the roots. Where days of emergence are known it is an animation: a step a day to
/// the last emergence, in which segments appear and grow older. Otherwise its axiom is that string, and it has no
/// productions. `roots` has no problemOfDays().
[[nodiscard]] std::string modelOf(const RootSystem& roots);

/// The labels in a file of the drawn roots beside their lines: plants, names, exact days. Empty for a table.
[[nodiscard]] turtle::RsmlLabels labelsOf(const RootSystem& roots);

}  // namespace espalier::roots
