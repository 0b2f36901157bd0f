#pragma once

#include <string>
#include <string_view>

namespace espalier::language {

/// The arrow of a rule that is written with `=`.
inline constexpr std::string_view kRuleMark = "\x1E";

/// A text of the textbook notation without comments and with ASCII characters for the signs of print, byte for byte at
/// the same places: `−` becomes `-` and blanks, `’` an apostrophe, a no-break space a blank. Blanks take the place of
/// what stands around statements on pages and in programs: `* ` and `1. ` before a line, quotation marks around strings
/// of modules, `{starting character string}`. Without any arrow, the `=` of rules such as `F=F+F` becomes an arrow
/// sign.
[[nodiscard]] std::string plainTextbook(std::string_view text);

}  // namespace espalier::language
