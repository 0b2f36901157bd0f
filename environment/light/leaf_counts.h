#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

// The state of the process `clover`: leaves over each cell of a raster, as bytes. Runs of equal counts are short.

[[nodiscard]] std::string saveLeafCounts(const std::vector<std::int32_t>& leaves);
/// Reads them back. A damaged state, or one of a raster of another size, is an error and changes nothing.
[[nodiscard]] std::optional<turtle::EnvironmentError> restoreLeafCounts(std::string_view state,
                                                                        std::vector<std::int32_t>& leaves);

}  // namespace espalier::environment
