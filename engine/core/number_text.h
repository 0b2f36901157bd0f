#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace espalier::core {

/// How numbers are written in strings of modules.
enum class NumberStyle : unsigned char {
  Shortest,  // shortest decimal that reads back as the same double; an exponent gets a point: 1.0e+05
  PercentG,  // C's %g, six significant digits
};

/// Appends a number in the given style. -0 prints as 0 in the Shortest style. Non-finite values print as nan, inf,
/// -inf.
void appendNumber(std::string& text, double value, NumberStyle style);

/// The value of a decimal number that fills all of `text` (as C's strtod without hexadecimal, inf or nan); nothing
/// otherwise.
[[nodiscard]] std::optional<double> parseNumber(std::string_view text);

/// The value that survives printing with %g and reading back.
[[nodiscard]] double roundThroughPercentG(double value);

}  // namespace espalier::core
