#pragma once

#include <span>
#include <string>

namespace espalier::derivation {

/// The text that printf makes of a format and numbers. Each conversion takes a number, or 0 when no number is left.
/// Integer conversions truncate the number. %% is a percent sign. Widths and precisions above 1000 count as 1000.
[[nodiscard]] std::string formatNumbers(const std::string& format, std::span<const double> numbers);

}  // namespace espalier::derivation
