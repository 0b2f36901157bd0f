#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::environment {

/// Writes the state of a process: little-endian numbers and length-prefixed texts.
class StateWriter {
 public:
  void integer(std::uint64_t value) {
    for (int i = 0; i < 8; ++i) {
      bytes_.push_back(static_cast<char>((value >> (8 * i)) & 0xFFU));
    }
  }
  void number(double value) { integer(std::bit_cast<std::uint64_t>(value)); }
  void text(std::string_view value) {
    integer(value.size());
    bytes_.append(value);
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads the bytes of a StateWriter. After the first item that is cut off, isIntact() is false and everything reads as
/// 0.
class StateReader {
 public:
  /// `bytes` must outlive the reader.
  explicit StateReader(std::string_view bytes) : rest_(bytes) {}

  [[nodiscard]] std::uint64_t integer() {
    if (rest_.size() < 8) {
      return fail();
    }
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) {
      value |= static_cast<std::uint64_t>(static_cast<unsigned char>(rest_[static_cast<std::size_t>(i)])) << (8 * i);
    }
    rest_.remove_prefix(8);
    return value;
  }
  [[nodiscard]] double number() { return std::bit_cast<double>(integer()); }
  /// A view into the bytes.
  [[nodiscard]] std::string_view text() {
    const std::uint64_t size = integer();
    if (size > rest_.size()) {
      fail();
      return {};
    }
    const std::string_view value = rest_.substr(0, static_cast<std::size_t>(size));
    rest_.remove_prefix(static_cast<std::size_t>(size));
    return value;
  }
  [[nodiscard]] bool isIntact() const { return isIntact_; }
  /// Everything was read and nothing was missing.
  [[nodiscard]] bool isComplete() const { return isIntact_ && rest_.empty(); }

 private:
  std::uint64_t fail() {
    isIntact_ = false;
    rest_ = {};
    return 0;
  }

  std::string_view rest_;
  bool isIntact_ = true;
};

}  // namespace espalier::environment
