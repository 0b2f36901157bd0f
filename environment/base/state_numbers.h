#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// Saves a state that is a list of numbers; the configuration of the process fixes its length. O(numbers).
[[nodiscard]] std::string saveNumbers(const std::vector<double>& numbers);

/// Reads it back. A damaged state, or one of another length, is an error that names the process and changes nothing.
[[nodiscard]] std::optional<turtle::EnvironmentError> restoreNumbers(std::string_view state, std::string_view process,
                                                                     std::vector<double>& numbers);

}  // namespace espalier::environment
