#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace espalier::derivation {

/// Reads numbers from `text` at `position` as C's fscanf does with this format, and moves `position` behind what was
/// read. Conversions: %d %i %u %o %x (whole numbers), %e %f %g (all numbers), %c (the code of a character), each with a
/// width or a `*` that reads without storing; %%; blanks of the format skip any blanks; other characters must match.
/// Numbers are put into `numbers` in order. Returns how many were, or -1 when the text ends before the first
/// conversion.
[[nodiscard]] int scanNumbers(std::string_view text, std::size_t& position, std::string_view format,
                              std::span<double> numbers);

}  // namespace espalier::derivation
