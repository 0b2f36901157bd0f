#pragma once

#include <algorithm>
#include <string_view>

namespace espalier::environment {

/// Equality of two names when the case of ASCII letters does not count.
[[nodiscard]] inline bool equalIgnoringCase(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace espalier::environment
