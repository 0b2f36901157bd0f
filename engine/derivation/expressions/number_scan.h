#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace espalier::derivation {

/// Reads numbers from `text` at `position` as C's fscanf does with this format, and moves `position` behind them.
/// Conversions: %d %i %u %o %x (whole numbers), %e %f %g (all numbers), %c (the code of a character), each with a width
/// or a `*` that reads without storing; %%. Blanks of the format skip any blanks; other characters must match. Stores
/// the numbers in `numbers`, in order. Returns their count, or -1 when the text ends before the first conversion.
[[nodiscard]] int scanNumbers(std::string_view text, std::size_t& position, std::string_view format,
                              std::span<double> numbers);

}  // namespace espalier::derivation
