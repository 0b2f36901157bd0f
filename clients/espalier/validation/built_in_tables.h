#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::validation {

/// The text of a table that the program carries (tables/): reference values that programs independent of Espalier
/// computed, and single published figures. Nothing for other names.
[[nodiscard]] std::optional<std::string> builtInTable(std::string_view name);

/// The names of all of them.
[[nodiscard]] std::vector<std::string_view> builtInTableNames();

/// Where the authors of a table that the program does not carry publish what it holds, by the file that a case misses:
/// a sentence. Empty for other names.
[[nodiscard]] std::string_view sourceOfTable(std::string_view missing);

}  // namespace espalier::validation
