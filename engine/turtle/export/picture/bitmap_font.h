#pragma once

#include <array>
#include <cstdint>

namespace espalier::turtle {

/// Rows of a letter; the baseline is below the lowest.
inline constexpr int kLetterRows = 7;

/// The five columns of a letter of printable ASCII from the left; bit 0 is the upper row. A box for anything else.
[[nodiscard]] std::array<std::uint8_t, 5> letterColumns(char letter);

}  // namespace espalier::turtle
