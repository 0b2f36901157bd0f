#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace espalier::simulation {

/// Builds bytes: little-endian numbers, texts and arrays behind their 64-bit length.
class ByteWriter {
 public:
  void byte(std::uint8_t value) { bytes_.push_back(static_cast<char>(value)); }
  void flag(bool value) { byte(value ? 1 : 0); }
  void number16(std::uint16_t value) { little(value, 2); }
  void number32(std::uint32_t value) { little(value, 4); }
  void number64(std::uint64_t value) { little(value, 8); }
  void real(double value) { number64(std::bit_cast<std::uint64_t>(value)); }
  void raw(std::string_view bytes) { bytes_.append(bytes); }
  void text(std::string_view value) {
    number64(value.size());
    raw(value);
  }
  void reals(std::span<const double> values) {
    number64(values.size());
    for (const double value : values) {
      real(value);
    }
  }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void little(std::uint64_t value, int byteCount) {
    for (int i = 0; i < byteCount; ++i) {
      bytes_.push_back(static_cast<char>((value >> (8 * i)) & 0xFFU));
    }
  }

  std::string bytes_;
};

}  // namespace espalier::simulation
