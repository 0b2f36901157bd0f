#pragma once

#include <bit>
#include <cstdint>
#include <string_view>

namespace espalier::core {

/// FNV-1a, 64 bits. It compares states and files; it gives no security.
class Hasher {
 public:
  void bytes(std::string_view text) {
    for (const char c : text) {
      hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
    }
  }
  void integer(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) {
      hash_ = (hash_ ^ ((value >> (8 * i)) & 0xFFU)) * 0x100000001b3ULL;
    }
  }
  /// Bit pattern of a double; -0 and 0 differ.
  void number(double value) { integer(std::bit_cast<std::uint64_t>(value)); }
  [[nodiscard]] std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ULL;
};

}  // namespace espalier::core
