#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

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

}  // namespace espalier::language
