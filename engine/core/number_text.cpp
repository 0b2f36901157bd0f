#include "engine/core/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <system_error>

namespace espalier::core {
namespace {

// powers of ten, all exact
constexpr std::array kPowers = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr std::array<std::uint32_t, 10> kWholePowers = {1,       10,        100,        1'000,       10'000,
                                                        100'000, 1'000'000, 10'000'000, 100'000'000, 1'000'000'000};

/// A decimal without an exponent: digits / 10^decimals, 0 <= decimals <= 9.
struct Decimal {
  std::uint64_t digits = 0;  // below 10^15
  std::size_t decimals = 0;
};

char* writeWhole(char* out, std::uint64_t whole) {
  if (whole < 10) {
    *out = static_cast<char>('0' + whole);
    return out + 1;
  }
  return std::to_chars(out, out + kMostNumberBytes, whole).ptr;
}

// without zeros at the end
char* writeDecimal(char* out, const Decimal& decimal) {
  const std::uint32_t unit = kWholePowers[decimal.decimals];
  out = writeWhole(out, decimal.digits / unit);
  auto rest = static_cast<std::uint32_t>(decimal.digits % unit);
  if (rest == 0) {
    return out;
  }
  *out++ = '.';
  char* end = out;
  for (std::size_t i = decimal.decimals; i-- > 0; rest /= 10) {
    const std::uint32_t digit = rest % 10;
    out[i] = static_cast<char>('0' + digit);
    end = end == out && digit != 0 ? out + i + 1 : end;
  }
  return end;
}

/// The shortest decimal of a positive number, where it has at most six places behind its point and no exponent. At most
/// one decimal of up to 15 digits reads back as a given double, so a decimal that does is the shortest one.
std::optional<Decimal> shortDecimal(double magnitude) {
  constexpr std::size_t kDecimals = 6;
  if (!(magnitude >= 1e-3 && magnitude < 1e9)) {
    return std::nullopt;
  }
  const auto whole = static_cast<std::uint64_t>(magnitude);
  if (static_cast<double>(whole) == magnitude) {
    // with five zeros at the end the form with an exponent can be shorter
    return whole >= 100'000 && whole % 100'000 == 0 ? std::nullopt : std::optional(Decimal{whole, 0});
  }
  const auto digits = static_cast<std::uint64_t>(magnitude * kPowers[kDecimals] + 0.5);
  return static_cast<double>(digits) / kPowers[kDecimals] == magnitude ? std::optional(Decimal{digits, kDecimals})
                                                                       : std::nullopt;
}

/// A positive number rounded to six significant digits, where %g writes no exponent and the rounding is certain.
std::optional<Decimal> sixDigits(double magnitude) {
  constexpr std::array kLeast = {1e-4, 1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};
  if (!(magnitude >= kLeast.front() && magnitude < kLeast.back())) {
    return std::nullopt;
  }
  std::size_t range = 0;
  while (magnitude >= kLeast[range + 1]) {
    ++range;
  }
  const std::size_t decimals = 9 - range;
  // 1e5 <= scaled < 1e6, with an error below 1e-9
  const double scaled = magnitude * kPowers[decimals];
  auto digits = static_cast<std::uint64_t>(scaled);
  const double rest = scaled - static_cast<double>(digits);
  if (std::abs(rest - 0.5) < 1e-6) {
    return std::nullopt;
  }
  digits += rest > 0.5 ? 1 : 0;
  // 999999.7 is 1e+06
  return digits == 1'000'000 && decimals == 0 ? std::nullopt : std::optional(Decimal{digits, decimals});
}

char* writeNonFinite(char* out, double value) {
  const std::string_view name = std::isnan(value) ? "nan" : (value < 0.0 ? "-inf" : "inf");
  return out + name.copy(out, name.size());
}

}  // namespace

char* writeNumber(char* out, double value, NumberStyle style) {
  const double magnitude = std::abs(value);
  if (const auto decimal = style == NumberStyle::Shortest ? shortDecimal(magnitude) : sixDigits(magnitude)) {
    if (value < 0.0) {
      *out++ = '-';
    }
    return writeDecimal(out, *decimal);
  }
  if (!std::isfinite(value)) {
    return writeNonFinite(out, value);
  }
  char* const limit = out + kMostNumberBytes;
  if (style == NumberStyle::PercentG) {
    return std::to_chars(out, limit, value, std::chars_format::general, 6).ptr;
  }
  if (value == 0.0) {
    *out = '0';
    return out + 1;
  }
  char* const end = std::to_chars(out, limit, value).ptr;
  char* const exponent = std::find(out, end, 'e');
  if (exponent == end || std::find(out, exponent, '.') != exponent) {
    return end;
  }
  // `1e+05` is no number of the language, `1.0e+05` is
  std::copy_backward(exponent, end, end + 2);
  exponent[0] = '.';
  exponent[1] = '0';
  return end + 2;
}

void appendNumber(std::string& text, double value, NumberStyle style) {
  std::array<char, kMostNumberBytes> buffer;
  text.append(buffer.data(), writeNumber(buffer.data(), value, style));
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
  const double magnitude = std::abs(value);
  if (const auto decimal = sixDigits(magnitude)) {
    // a quotient of two exact numbers is what reading the decimal gives
    return std::copysign(static_cast<double>(decimal->digits) / kPowers[decimal->decimals], value);
  }
  if (!std::isfinite(value)) {
    return value;
  }
  std::array<char, kMostNumberBytes> buffer;
  const char* const end = writeNumber(buffer.data(), value, NumberStyle::PercentG);
  double rounded = value;
  static_cast<void>(std::from_chars(buffer.data(), end, rounded));
  return rounded;
}

}  // namespace espalier::core
