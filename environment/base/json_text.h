#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "engine/core/diagnostic.h"

// Private to this folder's .cpp files: the JSON library's names do not leave it.

namespace espalier::environment {

/// Parses JSON text. On failure a Diagnostic at line and column of the text (called `file`) whose message is "is not
/// valid JSON: ..." or "has the key 'radius' twice", for the caller to complete. O(text).
[[nodiscard]] std::variant<nlohmann::json, core::Diagnostic> parseJson(std::string_view text, const std::string& file);

/// What a value is, for "found ...": "the text 'big'", "a list", "true", "the number 2.5", ...
[[nodiscard]] std::string foundText(const nlohmann::json& value);

}  // namespace espalier::environment
