#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::simulation {

/// Reads the output of ByteWriter from untrusted bytes. After a read beyond the end, or of a length that the remaining
/// bytes cannot hold, hasFailed() stays true and every read gives zeros and empty values. Never allocates more than the
/// bytes describe.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint8_t byte() { return static_cast<std::uint8_t>(little(1)); }
  [[nodiscard]] bool flag() { return byte() != 0; }
  [[nodiscard]] std::uint16_t number16() { return static_cast<std::uint16_t>(little(2)); }
  [[nodiscard]] std::uint32_t number32() { return static_cast<std::uint32_t>(little(4)); }
  [[nodiscard]] std::uint64_t number64() { return little(8); }
  [[nodiscard]] double real() { return std::bit_cast<double>(little(8)); }
  [[nodiscard]] std::string_view raw(std::uint64_t byteCount) {
    if (byteCount > remaining()) {
      hasFailed_ = true;
      return {};
    }
    const std::string_view part = bytes_.substr(position_, byteCount);
    position_ += byteCount;
    return part;
  }
  [[nodiscard]] std::string text() { return std::string(raw(number64())); }
  /// A count of elements of at least `bytesEach` bytes; fails when the bytes left cannot hold them.
  [[nodiscard]] std::uint64_t count(std::uint64_t bytesEach) {
    const std::uint64_t value = number64();
    if (value > remaining() / bytesEach) {
      hasFailed_ = true;
      return 0;
    }
    return value;
  }
  [[nodiscard]] std::vector<double> reals() {
    std::vector<double> values(count(8));
    for (double& value : values) {
      value = real();
    }
    return values;
  }

  /// For a caller that finds a value without meaning.
  void fail() { hasFailed_ = true; }
  [[nodiscard]] bool hasFailed() const { return hasFailed_; }
  [[nodiscard]] std::uint64_t remaining() const { return hasFailed_ ? 0 : bytes_.size() - position_; }

 private:
  std::uint64_t little(std::uint64_t byteCount) {
    const std::string_view part = raw(byteCount);
    std::uint64_t value = 0;
    for (std::size_t i = part.size(); i > 0; --i) {
      value = (value << 8U) | static_cast<std::uint8_t>(part[i - 1]);
    }
    return value;
  }

  std::string_view bytes_;
  std::size_t position_ = 0;
  bool hasFailed_ = false;
};

}  // namespace espalier::simulation
