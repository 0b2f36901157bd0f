#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "engine/core/vec3.h"
#include "engine/turtle/export/piece_output.h"

namespace espalier::turtle {

/// Little-endian binary numbers for a sink or a string, which have all of them after `flush`.
class BinaryOutput {
 public:
  explicit BinaryOutput(core::ByteSink& sink) : out_(sink) {}
  explicit BinaryOutput(std::string& bytes) : out_(bytes) {}

  void bytes(std::string_view text) { out_.bytes(text); }
  void byte(unsigned char value) { add(value); }
  void uint16(std::uint16_t value) { add(value); }
  void uint32(std::uint32_t value) { add(value); }
  template <std::size_t kCount>
  void uint32s(const std::array<std::uint32_t, kCount>& values) {
    add(values);
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
  void flush() { out_.flush(); }

 private:
  static_assert(std::endian::native == std::endian::little);

  template <typename Number>
  void add(Number value) {
    static_assert(sizeof(Number) <= PieceOutput::kMostRoom);
    std::memcpy(out_.room(sizeof(Number)), &value, sizeof(Number));
    out_.take(sizeof(Number));
  }

  PieceOutput out_;
};

}  // namespace espalier::turtle
