#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/work_meter.h"

namespace espalier::language {

/// A piece of a foreign text and where it is.
struct TextPiece {
  std::string_view text;
  std::size_t offset = 0;

  /// Without blanks, TABs and carriage returns at both ends.
  [[nodiscard]] TextPiece trimmed() const {
    const std::size_t begin = std::min(text.find_first_not_of(" \t\r"), text.size());
    const std::size_t last = text.find_last_not_of(" \t\r");
    return {last == std::string_view::npos ? std::string_view{} : text.substr(begin, last + 1 - begin), offset + begin};
  }
  [[nodiscard]] TextPiece from(std::size_t begin) const {
    const std::size_t at = std::min(begin, text.size());
    return {text.substr(at), offset + at};
  }
  [[nodiscard]] TextPiece to(std::size_t end) const { return {text.substr(0, end), offset}; }
  [[nodiscard]] bool empty() const { return text.empty(); }
};

/// The lines of a text without their newlines.
[[nodiscard]] inline std::vector<TextPiece> linesOf(std::string_view text, std::size_t offset = 0) {
  std::vector<TextPiece> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    core::pollWork();
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back({text.substr(begin, end - begin), offset + begin});
    begin = end + 1;
  }
  return lines;
}

[[nodiscard]] inline char lowered(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

[[nodiscard]] inline std::string lowered(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) { return lowered(c); });
  return result;
}

/// Bytes of the UTF-8 character that begins with `first`.
[[nodiscard]] inline std::size_t characterLength(char first) {
  const auto byte = static_cast<unsigned char>(first);
  return byte < 0xC0 ? 1U : byte < 0xE0 ? 2U : byte < 0xF0 ? 3U : 4U;
}

}  // namespace espalier::language
