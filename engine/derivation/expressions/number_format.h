#pragma once

#include <span>
#include <string>

namespace espalier::derivation {

/// The text that printf makes of a format and numbers: one number per conversion, 0 where numbers are missing; integer
/// conversions get the number truncated; %% is a percent sign. Widths and precisions above 1000 are cut.
[[nodiscard]] std::string formatNumbers(const std::string& format, std::span<const double> numbers);

}  // namespace espalier::derivation
