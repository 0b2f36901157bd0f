#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::protocol {

// Looking into a JSON text without a JSON library.

/// One member of a JSON object: the text of a string, or the compact JSON of anything else. Nothing when `json` is not
/// an object or has no such member.
[[nodiscard]] std::optional<std::string> memberOf(std::string_view json, std::string_view name);

/// The member `name` of a JSON object, when it is itself an object whose members are all texts. Otherwise nothing.
[[nodiscard]] std::optional<std::map<std::string, std::string>> textsOf(std::string_view json, std::string_view name);

/// The member `name` of a JSON object, when it is an array of texts. Otherwise nothing.
[[nodiscard]] std::optional<std::vector<std::string>> listOf(std::string_view json, std::string_view name);

/// Whether bytes are text that JSON can carry: UTF-8 without a zero byte.
[[nodiscard]] bool isPlainText(std::string_view bytes);

/// The first bytes of a text of UTF-8, at most so many, without a part of a character at the end.
[[nodiscard]] std::string_view beginningOf(std::string_view text, std::size_t mostBytes);

/// The reason why a text is not one JSON value, as `parse error at line 3, column 7: ...`, or that it is nested too
/// deeply or has an object with a name twice. Nothing when it can be read.
[[nodiscard]] std::optional<std::string> jsonProblem(std::string_view json);

}  // namespace espalier::protocol
