#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

/// How the picture readers look at the bytes of a file.
namespace espalier::files {

inline constexpr const char* kImageIsCutOff = "the file ends before the picture is complete";

/// Byte i of a file; 0 beyond its end.
[[nodiscard]] inline std::uint8_t byteAt(std::string_view bytes, std::size_t i) {
  return i < bytes.size() ? static_cast<std::uint8_t>(bytes[i]) : std::uint8_t{0};
}

/// A whole number of `count` bytes, the highest first.
[[nodiscard]] inline std::uint32_t bigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8U | byteAt(bytes, at + i);
  }
  return value;
}

/// A whole number of two bytes, the lowest first.
[[nodiscard]] inline std::uint32_t littleEndian16(std::string_view bytes, std::size_t at) {
  return byteAt(bytes, at) | static_cast<std::uint32_t>(byteAt(bytes, at + 1)) << 8U;
}

}  // namespace espalier::files
