#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace espalier::server {

/// A piece of a text: bytes of an earlier one, or its own.
struct TextPiece {
  std::size_t from = 0;   // first byte in the earlier text
  std::size_t count = 0;  // bytes taken from there; 0: `own`
  std::string_view own;   // refers to the later text
};

/// The pieces whose concatenation is `text`. Stretches of at least 16 bytes in common are found wherever they are; a
/// stretch whose beginning occurs several times in `base` may be split. O(bytes).
[[nodiscard]] std::vector<TextPiece> differenceOf(std::string_view base, std::string_view text);

}  // namespace espalier::server
