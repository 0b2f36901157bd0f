#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "engine/core/vec3.h"

namespace espalier::turtle {

/// Collects text and hands it to a sink in large pieces, or appends it to a string.
class TextOutput {
 public:
  explicit TextOutput(core::ByteSink& sink) : sink_(&sink), text_(&own_) {}
  explicit TextOutput(std::string& text) : text_(&text) {}
  ~TextOutput() { flush(); }
  TextOutput(const TextOutput&) = delete;
  TextOutput& operator=(const TextOutput&) = delete;

  TextOutput& operator<<(std::string_view text) {
    if (sink_ != nullptr && text.size() > kPieceBytes) {
      flush();
      sink_->write(text);
      return *this;
    }
    text_->append(text);
    if (text_->size() > kPieceBytes) {
      flush();
    }
    return *this;
  }
  TextOutput& operator<<(char character) { return *this << std::string_view(&character, 1); }
  TextOutput& integer(long long value) {
    std::array<char, 24> buffer;
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return *this << std::string_view(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
  }
  /// A number with at most `decimals` digits after the point, without trailing zeros and without -0. Not finite: 0.
  TextOutput& number(double value, int decimals) {
    std::array<char, 400> buffer;
    if (!std::isfinite(value)) {
      value = 0.0;
    }
    const auto result =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
    std::string_view text(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
    if (text.find('.') != std::string_view::npos) {
      while (text.ends_with('0')) {
        text.remove_suffix(1);
      }
      if (text.ends_with('.')) {
        text.remove_suffix(1);
      }
    }
    return *this << (text == "-0" ? std::string_view("0") : text);
  }
  /// The shortest text that reads back as the same 32-bit number; never -0. Not finite: 0.
  TextOutput& single(double value) {
    std::array<char, 48> buffer;
    const float rounded = std::isfinite(value) ? static_cast<float>(value) + 0.0F : 0.0F;
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), rounded);
    return *this << std::string_view(buffer.data(), static_cast<std::size_t>(result.ptr - buffer.data()));
  }
  TextOutput& vector(const core::Vec3& v, char separator) {
    single(v.x) << separator;
    single(v.y) << separator;
    return single(v.z);
  }
  void flush() {
    if (sink_ != nullptr && !text_->empty()) {
      sink_->write(*text_);
      text_->clear();
    }
  }

 private:
  static constexpr std::size_t kPieceBytes = 65'536;
  core::ByteSink* sink_ = nullptr;  // null: the text belongs to the caller
  std::string own_;
  std::string* text_;
};

}  // namespace espalier::turtle
