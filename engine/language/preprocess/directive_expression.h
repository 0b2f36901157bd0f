#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::language {

/// A mistake in the expression of an #if: its bytes in the expression and a message.
struct DirectiveProblem {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::string message;
};

/// The value of an #if or #elif expression in which macros are already expanded and every `defined` is already 0 or 1:
/// C's integer operators on 64 bits, unknown names are 0. After a mistake: nothing, and `problem` is set.
/// Nesting deeper than `maximumDepth` is a mistake.
[[nodiscard]] std::optional<std::int64_t> evaluateDirective(std::string_view text, std::uint32_t maximumDepth,
                                                            DirectiveProblem& problem);

}  // namespace espalier::language
