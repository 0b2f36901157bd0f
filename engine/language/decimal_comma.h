#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "engine/core/diagnostic.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {

/// The hint for a comma at `comma` in `text` with digits on both sides, as in 0,5. Empty: it is another comma.
[[nodiscard]] inline std::string decimalCommaHint(std::string_view text, std::size_t comma) {
  std::size_t begin = std::min(comma, text.size());
  while (begin > 0 && isDigit(text[begin - 1])) {
    --begin;
  }
  std::size_t end = comma + 1;
  while (end < text.size() && isDigit(text[end])) {
    ++end;
  }
  if (begin == comma || end <= comma + 1 || comma >= text.size() || text[comma] != ',') {
    return {};
  }
  return "write " + std::string(text.substr(begin, comma - begin)) + "." +
         std::string(text.substr(comma + 1, end - comma - 1)) + " with a point";
}

/// The same for the only such comma between the parameters of the module that `range` holds. Empty for A(1,2,3), which
/// has two.
[[nodiscard]] inline std::string decimalCommaHint(std::string_view text, core::SourceRange range) {
  std::string only;
  int depth = 0;
  for (std::size_t i = range.begin; i < std::min<std::size_t>(range.end, text.size()); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (std::string hint = text[i] == ',' && depth == 1 ? decimalCommaHint(text, i) : std::string(); !hint.empty()) {
      if (!only.empty()) {
        return {};
      }
      only = std::move(hint);
    }
  }
  return only;
}

}  // namespace espalier::language
