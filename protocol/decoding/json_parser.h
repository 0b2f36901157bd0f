#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "protocol/errors.h"

namespace espalier::protocol {

// The parser of messages. For protocol's own .cpp files only.

inline constexpr std::size_t kDeepestNesting = 64;

/// Brackets are nested deeper than kDeepestNesting. The parser recurses, and must not run out of stack.
[[nodiscard]] bool isNestedTooDeeply(std::string_view json);

/// The parser's message without its exception numbers.
[[nodiscard]] std::string parserMessage(const nlohmann::json::exception& exception);

/// A parsed value. Its destructor takes no memory: that of the library moves the elements of each array into a new list
/// before it destroys them, which ends the program when the account of the peer has no more memory.
struct JsonTree {
  JsonTree() = default;
  explicit JsonTree(nlohmann::json parsed) : value(std::move(parsed)) {}
  ~JsonTree();
  JsonTree(JsonTree&&) noexcept = default;
  JsonTree& operator=(JsonTree&&) = delete;

  nlohmann::json value;
};

/// Why a text is refused.
struct JsonFault {
  enum class Kind : std::uint8_t { TooDeep, NotJson, RepeatedName };
  Kind kind = Kind::NotJson;
  std::string what;  // NotJson: the parser's message; RepeatedName: the name that an object has twice
};

/// Parses a text. Refuses one that is not JSON, is nested too deeply, or has an object with a name twice.
[[nodiscard]] tl::expected<JsonTree, JsonFault> parseTree(std::string_view text);

/// The same for a message, with the error that its sender gets.
[[nodiscard]] Expected<JsonTree> parseJson(std::string_view text);

}  // namespace espalier::protocol
