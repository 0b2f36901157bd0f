#pragma once

#include <string>

namespace espalier::command {

/// The description of an environment (`environment NAME --describe --json`) in words, with line ends: what it computes,
/// what a module sends and gets, and every key of its configuration with its default.
[[nodiscard]] std::string environmentInWords(const std::string& descriptionJson);

}  // namespace espalier::command
