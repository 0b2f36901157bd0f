#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "protocol/errors.h"

namespace espalier::protocol {

// The parser of messages. For protocol's own .cpp files only.

inline constexpr std::size_t kDeepestNesting = 64;

/// Brackets are nested deeper than kDeepestNesting. The parser recurses, and must not run out of stack.
[[nodiscard]] bool isNestedTooDeeply(std::string_view json);

/// The parser's message without its exception numbers.
[[nodiscard]] std::string parserMessage(const nlohmann::json::exception& exception);

/// Parses a message. Refuses a text that is not JSON, is nested too deeply, or has an object with a name twice.
[[nodiscard]] Expected<nlohmann::json> parseJson(std::string_view text);

}  // namespace espalier::protocol
