#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "engine/core/diagnostic.h"

namespace espalier::core {

/// Makes a text that a terminal can show: each byte that is not UTF-8 becomes '?', each control character but TABs a
/// blank. Line ends too, unless `keepsLines`. The number of bytes stays.
void makePrintable(std::string& text, bool keepsLines = false);

/// The number of characters of a UTF-8 text; a byte that is not UTF-8 counts as one.
[[nodiscard]] std::size_t characterCount(std::string_view text);

/// "tree.l:12:33": the column counts characters, as editors show it, and not bytes.
[[nodiscard]] std::string placeText(const SourceLocation& place);

/// A message for a terminal: printable, and a line of more than 200 columns goes on below. `used` columns stand before
/// the text.
[[nodiscard]] std::string messageText(std::string text, std::size_t used = 0);

}  // namespace espalier::core
