#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// Fractint's L-system files: several entries `Name { ... }` with `Angle N` (a turn is 360/N degrees), `Axiom` and
/// rules `X=...`; `;` begins a comment; letter case does not matter; strings are in capitals. The turtle
/// starts along +x, and + turns left. Numbers become parameters: `@.6` is `@(0.6)`, `\30` is `\(30)`, `C5` is `C(5)`;
/// `<` and `>` become as many `;` and `,` as their numbers. The symbols + - | turn the heading of F and G; \ and / turn
/// the heading of D and M, in degrees. An entry that uses both keeps the second in the turtle's other orientation
/// (`@X`).
[[nodiscard]] bool recognisesFractint(std::string_view text);
[[nodiscard]] std::vector<DialectEntry> fractintEntries(std::string_view text);
[[nodiscard]] CpfgModel translateFractint(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
