#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/work_meter.h"
#include "engine/turtle/environment_process.h"

namespace espalier::environment {

// The state of the process `clover`: leaves over each cell of a raster.

/// Calls `stamp(query)` for each of `queries`, which changes `leaves`, about `cellCount` times in all; `forgets`: those
/// of earlier steps are removed first. A long step can be given up, and they are as before then.
template <typename Stamp>
void stampAll(std::span<const std::size_t> queries, double cellCount, bool forgets, std::vector<std::int32_t>& leaves,
              const Stamp& stamp) {
  constexpr double kLong = 4.0;  // times the raster; a copy costs about as much as changing half of its cells
  const bool isLong = cellCount > kLong * static_cast<double>(leaves.size());
  std::vector<std::int32_t> before;
  if (isLong) {
    before = leaves;
  }
  if (forgets) {
    std::ranges::fill(leaves, 0);
  }
  try {
    for (const std::size_t query : queries) {
      if (isLong) {
        core::pollWork();
      }
      stamp(query);
    }
  } catch (const core::WorkStopped&) {
    leaves.swap(before);
    throw;
  }
}

// As bytes: runs of equal counts are short.

[[nodiscard]] std::string saveLeafCounts(const std::vector<std::int32_t>& leaves);
/// Reads them back. A damaged state, or one of a raster of another size, is an error and changes nothing.
[[nodiscard]] std::optional<turtle::EnvironmentError> restoreLeafCounts(std::string_view state,
                                                                        std::vector<std::int32_t>& leaves);

}  // namespace espalier::environment
