#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::core {

/// The two forms of a number in the text of a module string.
enum class NumberStyle : unsigned char {
  Shortest,  // shortest decimal that reads back as the same double; an exponent gets a point: 1.0e+05
  PercentG,  // C's %g, six significant digits
};

/// The bytes that the text of a number has at most, in any style.
inline constexpr std::size_t kMostNumberBytes = 32;

/// Writes a number in the given style to `out`, which has room for kMostNumberBytes. Returns the end of the text. -0
/// becomes 0 in the Shortest style. Values that are not finite become nan, inf and -inf.
[[nodiscard]] char* writeNumber(char* out, double value, NumberStyle style);

/// Appends the text of writeNumber.
void appendNumber(std::string& text, double value, NumberStyle style);

/// The value of a decimal number that fills all of `text`; nothing otherwise. Reads as C's strtod does, without
/// hexadecimal numbers, inf and nan.
[[nodiscard]] std::optional<double> parseNumber(std::string_view text);

/// The value that is left after printing with %g and reading back.
[[nodiscard]] double roundThroughPercentG(double value);

}  // namespace espalier::core
