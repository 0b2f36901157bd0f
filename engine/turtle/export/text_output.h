#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "engine/core/vec3.h"
#include "engine/turtle/export/piece_output.h"

namespace espalier::turtle {

/// Text for a sink or a string, which have all of it after `flush`.
class TextOutput {
 public:
  explicit TextOutput(core::ByteSink& sink) : out_(sink) {}
  explicit TextOutput(std::string& text) : out_(text) {}

  TextOutput& operator<<(std::string_view text) {
    out_.bytes(text);
    return *this;
  }
  TextOutput& operator<<(char character) {
    *out_.room(1) = character;
    out_.take(1);
    return *this;
  }
  TextOutput& integer(long long value) {
    return spell(kMostDigits, [value](char* to) { return std::to_chars(to, to + kMostDigits, value).ptr; });
  }
  /// A number with at most `decimals` digits after the point, without trailing zeros and without -0. Not finite: 0.
  TextOutput& number(double value, int decimals) {
    const double finite = std::isfinite(value) ? value : 0.0;
    return spell(kMostFixed, [finite, decimals](char* to) {
      const char* const end = std::to_chars(to, to + kMostFixed, finite, std::chars_format::fixed, decimals).ptr;
      std::string_view text(to, static_cast<std::size_t>(end - to));
      if (text.find('.') != std::string_view::npos) {
        while (text.ends_with('0')) {
          text.remove_suffix(1);
        }
        if (text.ends_with('.')) {
          text.remove_suffix(1);
        }
      }
      if (text == "-0") {
        *to = '0';
        text.remove_suffix(1);
      }
      return to + text.size();
    });
  }
  /// The shortest text that reads back as the same 32-bit number; never -0. Not finite: 0.
  TextOutput& single(double value) {
    const float rounded = std::isfinite(value) ? static_cast<float>(value) + 0.0F : 0.0F;
    return spell(kMostShortest, [rounded](char* to) { return std::to_chars(to, to + kMostShortest, rounded).ptr; });
  }
  TextOutput& vector(const core::Vec3& v, char separator) {
    single(v.x) << separator;
    single(v.y) << separator;
    return single(v.z);
  }
  void flush() { out_.flush(); }

 private:
  static constexpr std::size_t kMostDigits = 24;
  static constexpr std::size_t kMostShortest = 48;
  static constexpr std::size_t kMostFixed = 400;

  // `write` spells at most so many characters at a place and returns their end
  template <typename Write>
  TextOutput& spell(std::size_t most, const Write& write) {
    char* const to = out_.room(most);
    out_.take(static_cast<std::size_t>(write(to) - to));
    return *this;
  }

  PieceOutput out_;
};

}  // namespace espalier::turtle
