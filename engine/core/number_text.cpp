#include "engine/core/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace espalier::core {
namespace {

// sign, 17 digits, point, exponent
using NumberBuffer = std::array<char, 40>;

void appendNonFinite(std::string& text, double value) {
  if (std::isnan(value)) {
    text += "nan";
  } else {
    text += value < 0.0 ? "-inf" : "inf";
  }
}

}  // namespace

void appendNumber(std::string& text, double value, NumberStyle style) {
  if (!std::isfinite(value)) {
    appendNonFinite(text, value);
    return;
  }
  NumberBuffer buffer;
  char* const begin = buffer.data();
  char* const limit = begin + buffer.size();
  if (style == NumberStyle::PercentG) {
    const std::to_chars_result result = std::to_chars(begin, limit, value, std::chars_format::general, 6);
    text.append(begin, result.ptr);
    return;
  }
  if (value == 0.0) {
    text += '0';
    return;
  }
  const std::to_chars_result result = std::to_chars(begin, limit, value);
  const std::string_view digits(begin, static_cast<std::size_t>(result.ptr - begin));
  const std::size_t exponent = digits.find('e');
  if (exponent == std::string_view::npos || digits.substr(0, exponent).find('.') != std::string_view::npos) {
    text += digits;
    return;
  }
  // `1e+05` is no number of the language, `1.0e+05` is
  text += digits.substr(0, exponent);
  text += ".0";
  text += digits.substr(exponent);
}

std::optional<double> parseNumber(std::string_view text) {
  // from_chars takes no leading plus, and reads inf and nan, which are no numbers here
  std::string_view digits = text;
  if (!digits.empty() && digits.front() == '+') {
    digits.remove_prefix(1);
    if (!digits.empty() && digits.front() == '-') {
      return std::nullopt;
    }
  }
  if (digits.empty() || digits.find_first_not_of("+-.0123456789eE") != std::string_view::npos) {
    return std::nullopt;
  }
  double value = 0.0;
  const std::from_chars_result result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ptr != digits.data() + digits.size()) {
    return std::nullopt;
  }
  if (result.ec == std::errc::result_out_of_range) {
    // as strtod: too large is infinite, too small is 0; the exponent's sign tells which, or the digits before the point
    const std::size_t exponent = digits.find_first_of("eE");
    const std::size_t significant = digits.find_first_not_of("-0");
    const bool isTiny = exponent != std::string_view::npos ? digits.find('-', exponent) != std::string_view::npos
                                                           : digits[significant] == '.';
    const double magnitude = isTiny ? 0.0 : HUGE_VAL;
    return digits.front() == '-' ? -magnitude : magnitude;
  }
  return result.ec == std::errc() ? std::optional<double>(value) : std::nullopt;
}

double roundThroughPercentG(double value) {
  if (!std::isfinite(value)) {
    return value;
  }
  NumberBuffer buffer;
  const std::to_chars_result written =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 6);
  double rounded = value;
  static_cast<void>(std::from_chars(buffer.data(), written.ptr, rounded));
  return rounded;
}

}  // namespace espalier::core
