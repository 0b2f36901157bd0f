#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::language {

/// The strings of successive derivation steps, as numbers: symbol s is called names[s].
struct StepStrings {
  std::vector<std::string>
      names;  // a character each (a UTF-8 sequence), with its parameters, in the order of appearance
  std::vector<std::vector<std::uint16_t>> strings;  // the axiom first (at least 2)

  /// The text of symbols.
  [[nodiscard]] std::string text(const std::vector<std::uint16_t>& symbols) const;
};

/// Reads one string a line: alone, or after the number of its step and a TAB as `espalier derive --every` prints them.
/// Every character is a symbol; a module with parameters such as /(180) is one symbol. Blanks between symbols and blank
/// lines are ignored (an erased string is a number and a TAB). Numbers must be successive. Mistakes are errors in
/// `diagnostics`: a parenthesis that belongs to no module, a number that is not the next one, text that is not
/// UTF-8, fewer than two strings. The result is complete when there was no error.
[[nodiscard]] StepStrings readStepStrings(const std::string& fileName, std::string_view text,
                                          core::DiagnosticList& diagnostics);

}  // namespace espalier::language
