#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace espalier::environment {

/// A colour image: three bytes (red, green, blue) a pixel, rows from the bottom upwards.
struct Image {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<std::uint8_t> bytes;  // (height, width, 3)

  /// Channel 0 red, 1 green, 2 blue; row 0 is the lowest.
  [[nodiscard]] std::uint8_t at(std::size_t x, std::size_t row, std::size_t channel) const {
    return bytes[(row * width + x) * 3 + channel];
  }
};

/// Decodes the content of an image file, told by its first bytes: PNG, SGI `rgb` (plain or run-length, one byte a
/// channel; grey when it has one or two channels) or PNM (P2, P3, P5, P6). A sentence when it is none of them, damaged
/// or beyond 2^26 pixels. O(pixels).
[[nodiscard]] std::variant<Image, std::string> decodeImage(std::string_view content);

}  // namespace espalier::environment
