#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "engine/core/vec3.h"

namespace espalier::turtle {

/// Collects little-endian binary numbers and hands them to a sink in large pieces, or appends them to a string.
class BinaryOutput {
 public:
  explicit BinaryOutput(core::ByteSink& sink) : sink_(&sink), buffer_(&own_) {}
  explicit BinaryOutput(std::string& bytes) : buffer_(&bytes) {}
  ~BinaryOutput() { flush(); }
  BinaryOutput(const BinaryOutput&) = delete;
  BinaryOutput& operator=(const BinaryOutput&) = delete;

  void bytes(std::string_view text) {
    if (sink_ != nullptr && text.size() > kPieceBytes) {
      flush();
      sink_->write(text);
      return;
    }
    buffer_->append(text);
    if (buffer_->size() > kPieceBytes) {
      flush();
    }
  }
  void byte(unsigned char value) { add(value); }
  void uint16(std::uint16_t value) { add(value); }
  void uint32(std::uint32_t value) { add(value); }
  void uint32s(std::span<const std::uint32_t> values) {
    bytes({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  }
  void single(double value) { add(static_cast<float>(value)); }
  void vector(const core::Vec3& v) { singles(std::array{v.x, v.y, v.z}); }
  template <std::size_t kCount>
  void singles(const std::array<double, kCount>& values) {
    std::array<float, kCount> singles;
    std::transform(values.begin(), values.end(), singles.begin(),
                   [](double value) { return static_cast<float>(value); });
    add(singles);
  }
  void flush() {
    if (sink_ != nullptr && !buffer_->empty()) {
      sink_->write(*buffer_);
      buffer_->clear();
    }
  }

 private:
  static_assert(std::endian::native == std::endian::little);
  static constexpr std::size_t kPieceBytes = 65'536;

  template <typename Number>
  void add(Number value) {
    char raw[sizeof(Number)];
    std::memcpy(raw, &value, sizeof(Number));
    bytes({raw, sizeof(Number)});
  }

  core::ByteSink* sink_ = nullptr;  // null: the bytes belong to the caller
  std::string own_;
  std::string* buffer_;
};

}  // namespace espalier::turtle
