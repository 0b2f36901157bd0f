#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace espalier::command {

/// A value, or a sentence that says what is wrong and what to do.
template <typename Value>
using Result = tl::expected<Value, std::string>;

/// A problem as the return value of a function with a Result.
[[nodiscard]] inline tl::unexpected<std::string> problem(std::string sentence) {
  return tl::unexpected<std::string>(std::move(sentence));
}

}  // namespace espalier::command
