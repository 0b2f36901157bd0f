#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace espalier::protocol {

/// Numbers in the `code` of an error. Frozen: a number is never reused or changed. errors.def says what each means.
enum class ErrorCode : std::int32_t {
#define ESPALIER_ERROR(name, code, text, meaning, data, remedy) name = code,
#include "protocol/errors.def"
};

/// A row of errors.def.
struct ErrorInfo {
  ErrorCode code = ErrorCode::Internal;
  std::string_view name;
  std::string_view meaning;
  std::string_view data;    // Markdown: the members of `data`
  std::string_view remedy;  // Markdown: what the reader of the message does
};

/// All rows, in the order of errors.def.
[[nodiscard]] std::span<const ErrorInfo> allErrors();

/// The name of a code as in errors.def; "unknown" for other numbers.
[[nodiscard]] std::string_view nameOf(ErrorCode code);

/// An error as it crosses the wire.
struct Error {
  ErrorCode code = ErrorCode::Internal;
  std::string message;  // whole sentences: what happened and what to do next
  std::string data;     // text of a JSON object; empty: none
};

/// A value, or the error that takes its place.
template <typename T>
using Expected = tl::expected<T, Error>;

/// Error with `data` = {"path": path}; the message starts with the path.
[[nodiscard]] Error memberError(const std::string& path, const std::string& what);

/// Error with `data` = {"limit", "value", "bound"}. The message names all three and ends in `remedy`.
[[nodiscard]] Error limitError(std::string_view limit, std::uint64_t value, std::uint64_t bound,
                               std::string_view remedy);

}  // namespace espalier::protocol
