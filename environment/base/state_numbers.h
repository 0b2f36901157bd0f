#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// The state of a process that is a list of numbers whose length its configuration fixes. O(numbers).
[[nodiscard]] std::string saveNumbers(const std::vector<double>& numbers);

/// Reads it back; an error that names the process when it is damaged or of another length, and then changes nothing.
[[nodiscard]] std::optional<turtle::EnvironmentError> restoreNumbers(std::string_view state, std::string_view process,
                                                                     std::vector<double>& numbers);

}  // namespace espalier::environment
