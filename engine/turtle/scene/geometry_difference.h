#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/turtle/scene/geometry.h"

namespace espalier::turtle {

/// Some rows of a table of geometry one after the other.
struct GeometryRun {
  static constexpr std::uint32_t kNew = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t first = 0;        // row of the table before; kNew: the next rows of those added
  std::uint32_t count = 0;        // rows
  std::uint64_t moduleShift = 0;  // added to their module indices, modulo 2^64; 0 for new rows

  bool operator==(const GeometryRun&) const = default;
};

/// A geometry as the changes from the one before. Its tables are runs of earlier rows, whose modules may have other
/// indices now, and new rows. The growth of a step is in `added`; the rest is a few runs.
struct GeometryDifference {
  std::vector<GeometryRun> segments, organs;  // in the order of the rows
  Geometry added;                             // the new rows
};

/// Expected O(rows + vertices): one pass over both while few rows change. Where the two differ for long, a table of all
/// rows is built.
[[nodiscard]] GeometryDifference differenceOf(const Geometry& before, const Geometry& now);

/// Makes `now`, which is cleared first, from the geometry before and the difference: differenceOf's inverse, bit by
/// bit. An error sentence when the difference does not belong to this geometry; then `now` has no meaning.
[[nodiscard]] std::optional<std::string> applyDifference(const Geometry& before, const GeometryDifference& difference,
                                                         Geometry& now);

}  // namespace espalier::turtle
