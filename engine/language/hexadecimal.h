#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

namespace espalier::language {

/// The hint for the rest `x1F` of a number such as 0x1F, which begins at `begin` in `text`: numbers are decimal. Empty:
/// it is another text.
[[nodiscard]] inline std::string hexadecimalHint(std::string_view text, std::size_t begin) {
  if (begin == 0 || begin + 1 >= text.size() || text[begin - 1] != '0' || (text[begin] != 'x' && text[begin] != 'X')) {
    return {};
  }
  std::uint64_t value = 0;
  const char* const digits = text.data() + begin + 1;
  const auto [end, error] = std::from_chars(digits, text.data() + text.size(), value, 16);
  if (error != std::errc()) {
    return {};
  }
  return "numbers are decimal: write " + std::to_string(value) + " in place of 0" +
         std::string(text.substr(begin, static_cast<std::size_t>(end - digits) + 1));
}

}  // namespace espalier::language
