#include "engine/derivation/expressions/number_scan.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <system_error>

namespace espalier::derivation {
namespace {

bool isBlank(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// One conversion of the format.
struct ScanConversion {
  bool isStored = true;
  std::size_t width = std::numeric_limits<std::size_t>::max();
  char letter = 'g';
};

/// Reads the conversion behind a `%` and moves `i` behind its letter. Nothing: the format ends before the letter.
std::optional<ScanConversion> readConversion(std::string_view format, std::size_t& i) {
  ScanConversion conversion;
  if (i < format.size() && format[i] == '*') {
    conversion.isStored = false;
    ++i;
  }
  std::size_t width = 0;
  for (; i < format.size() && isDigit(format[i]); ++i) {
    width = std::min<std::size_t>(1'000'000, width * 10 + static_cast<std::size_t>(format[i] - '0'));
  }
  if (width > 0) {
    conversion.width = width;
  }
  while (i < format.size() && std::string_view("hlLqjzt").find(format[i]) != std::string_view::npos) {
    ++i;
  }
  if (i >= format.size()) {
    return std::nullopt;
  }
  conversion.letter = format[i++];
  return conversion;
}

/// A whole number at the beginning of `field`; `length` receives its characters.
std::optional<double> wholeNumber(std::string_view field, int base, std::size_t& length) {
  std::size_t i = 0;
  const bool isNegative = i < field.size() && field[i] == '-';
  if (i < field.size() && (field[i] == '-' || field[i] == '+')) {
    ++i;
  }
  const auto hasHexPrefix = [&] {
    return field.size() > i + 1 && field[i] == '0' && (field[i + 1] == 'x' || field[i + 1] == 'X');
  };
  if (base == 0) {
    base = hasHexPrefix() ? 16 : i < field.size() && field[i] == '0' ? 8 : 10;
  }
  if (base == 16 && hasHexPrefix()) {
    i += 2;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(field.data() + i, field.data() + field.size(), value, base);
  if (error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  length = static_cast<std::size_t>(end - field.data());
  const double magnitude = error == std::errc::result_out_of_range ? 9.2e18 : static_cast<double>(value);
  return isNegative ? -magnitude : magnitude;
}

/// Any number at the beginning of `field`.
std::optional<double> realNumber(std::string_view field, std::size_t& length) {
  // from_chars knows no plus sign
  const std::size_t sign = !field.empty() && field.front() == '+' ? 1 : 0;
  if (sign == 1 && field.size() > 1 && (field[1] == '-' || field[1] == '+')) {
    return std::nullopt;
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data() + sign, field.data() + field.size(), value);
  if (error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  length = static_cast<std::size_t>(end - field.data());
  if (error == std::errc::result_out_of_range) {
    // too small or too large for a double: 0, or the largest
    const bool isTiny = field.substr(0, length).find_first_of("eE") != std::string_view::npos
                            ? field.substr(0, length).find("e-") != std::string_view::npos ||
                                  field.substr(0, length).find("E-") != std::string_view::npos
                            : field.find_first_not_of("+-0.") > field.find('.');
    const double bound = isTiny ? 0.0 : std::numeric_limits<double>::max();
    return field.front() == '-' ? -bound : bound;
  }
  return value;
}

std::optional<double> readNumber(std::string_view field, const ScanConversion& conversion, std::size_t& length) {
  switch (conversion.letter) {
    case 'd':
    case 'u':
      return wholeNumber(field, 10, length);
    case 'i':
      return wholeNumber(field, 0, length);
    case 'o':
      return wholeNumber(field, 8, length);
    case 'x':
    case 'X':
      return wholeNumber(field, 16, length);
    case 'c':
      length = 1;
      return static_cast<double>(static_cast<unsigned char>(field.front()));
    default:
      return realNumber(field, length);
  }
}

}  // namespace

int scanNumbers(std::string_view text, std::size_t& position, std::string_view format, std::span<double> numbers) {
  position = std::min(position, text.size());
  const auto skipBlanks = [&] {
    while (position < text.size() && isBlank(text[position])) {
      ++position;
    }
  };
  std::size_t stored = 0;
  bool hasConverted = false;
  for (std::size_t i = 0; i < format.size();) {
    const char c = format[i++];
    if (isBlank(c)) {
      skipBlanks();
      continue;
    }
    if (c != '%' || (i < format.size() && format[i] == '%')) {
      // a character to match; `%%` skips blanks as the other conversions do
      if (c == '%') {
        ++i;
        skipBlanks();
      }
      if (position >= text.size()) {
        return hasConverted ? static_cast<int>(stored) : -1;
      }
      if (text[position] != c) {
        return static_cast<int>(stored);
      }
      ++position;
      continue;
    }
    const std::optional<ScanConversion> conversion = readConversion(format, i);
    if (!conversion) {
      break;
    }
    if (conversion->letter != 'c') {
      skipBlanks();
    }
    if (position >= text.size()) {
      return hasConverted ? static_cast<int>(stored) : -1;
    }
    std::size_t length = 0;
    const std::optional<double> number = readNumber(text.substr(position, conversion->width), *conversion, length);
    if (!number) {
      break;
    }
    position += length;
    hasConverted = true;
    if (conversion->isStored) {
      if (stored >= numbers.size()) {
        break;
      }
      numbers[stored++] = *number;
    }
  }
  return static_cast<int>(stored);
}

}  // namespace espalier::derivation
