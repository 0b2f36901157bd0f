#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/core/diagnostic.h"

// Private to this folder's .cpp files: the JSON library's names do not leave it.

namespace espalier::environment {

/// Parses JSON text. The error has the line and column in the text (called `file`); the caller completes its message,
/// which is "is not valid JSON: ...", "has the key 'radius' twice" or "is nested more than 200 deep". O(text log keys).
[[nodiscard]] tl::expected<nlohmann::json, core::Diagnostic> parseJson(std::string_view text, const std::string& file);

/// The value in words, for "found ...": "the text 'big'", "a list", "true", "the number 2.5", ...
[[nodiscard]] std::string foundText(const nlohmann::json& value);

}  // namespace espalier::environment
