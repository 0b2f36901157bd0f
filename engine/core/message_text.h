#pragma once

#include <cstddef>
#include <string>

namespace espalier::core {

/// Makes a text that a terminal can show: each byte that is not UTF-8 becomes '?', each control character but TABs a
/// blank. Line ends too, unless `keepsLines`. The number of bytes stays.
void makePrintable(std::string& text, bool keepsLines = false);

/// A message for a terminal: printable, and a line of more than 200 columns goes on below. `used` columns stand before
/// the text.
[[nodiscard]] std::string messageText(std::string text, std::size_t used = 0);

}  // namespace espalier::core
