#include "engine/derivation/expressions/number_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string_view>

namespace espalier::derivation {
namespace {

constexpr int kMaximumWidth = 1000;

bool isOneOf(char c, std::string_view set) {
  return set.find(c) != std::string_view::npos;
}

/// One conversion of a printf format.
struct Conversion {
  std::string flags;
  int width = 0;
  int precision = -1;  // -1: none given
  char letter = 'g';
};

int readNumber(const std::string& format, std::size_t& i) {
  int number = 0;
  for (; i < format.size() && format[i] >= '0' && format[i] <= '9'; ++i) {
    number = std::min(kMaximumWidth, number * 10 + (format[i] - '0'));
  }
  return number;
}

/// Reads the conversion behind a `%` and moves `i` behind its letter. False: the format ends before the letter.
bool readConversion(const std::string& format, std::size_t& i, Conversion& conversion) {
  for (; i < format.size() && isOneOf(format[i], "-+ #0"); ++i) {
    if (!isOneOf(format[i], conversion.flags)) {
      conversion.flags.push_back(format[i]);
    }
  }
  conversion.width = readNumber(format, i);
  if (i < format.size() && format[i] == '.') {
    ++i;
    conversion.precision = readNumber(format, i);
  }
  while (i < format.size() && isOneOf(format[i], "hlLqjzt")) {
    ++i;
  }
  if (i >= format.size()) {
    return false;
  }
  conversion.letter = format[i++];
  return true;
}

std::int64_t toInteger(double value) {
  if (std::isnan(value)) {
    return 0;
  }
  return static_cast<std::int64_t>(std::clamp(value, -9.2e18, 9.2e18));
}

void appendConversion(std::string& text, const Conversion& conversion, double value) {
  std::string specification = "%" + conversion.flags;
  if (conversion.width > 0) {
    specification += std::to_string(conversion.width);
  }
  if (conversion.precision >= 0 && conversion.letter != 'c') {
    specification += "." + std::to_string(conversion.precision);
  }
  // wide enough for the largest number with the largest precision
  std::array<char, 4096> buffer{};
  int length = 0;
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  if (isOneOf(conversion.letter, "diouxX")) {
    specification += "ll";
    specification.push_back(conversion.letter);
    length =
        std::snprintf(buffer.data(), buffer.size(), specification.c_str(), static_cast<long long>(toInteger(value)));
  } else if (conversion.letter == 'c') {
    specification.push_back('c');
    length =
        std::snprintf(buffer.data(), buffer.size(), specification.c_str(), static_cast<int>(toInteger(value) & 0xFF));
  } else {
    // only numbers exist: %s and unknown letters print like %g
    specification.push_back(isOneOf(conversion.letter, "eEfFgGaA") ? conversion.letter : 'g');
    length = std::snprintf(buffer.data(), buffer.size(), specification.c_str(), value);
  }
#pragma GCC diagnostic pop
  if (length > 0) {
    text.append(buffer.data(), std::min(static_cast<std::size_t>(length), buffer.size() - 1));
  }
}

}  // namespace

std::string formatNumbers(const std::string& format, std::span<const double> numbers) {
  std::string text;
  std::size_t used = 0;
  for (std::size_t i = 0; i < format.size();) {
    const char c = format[i++];
    if (c != '%') {
      text.push_back(c);
      continue;
    }
    if (i < format.size() && format[i] == '%') {
      text.push_back('%');
      ++i;
      continue;
    }
    Conversion conversion;
    if (!readConversion(format, i, conversion)) {
      break;
    }
    const double value = used < numbers.size() ? numbers[used] : 0.0;
    ++used;
    appendConversion(text, conversion, value);
  }
  return text;
}

}  // namespace espalier::derivation
