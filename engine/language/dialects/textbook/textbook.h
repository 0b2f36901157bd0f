#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// The notation of book chapters, lectures and papers: `ω: F`, `p1: F → F[+F]F`, `→ (1/3)F` or `: 0.33`, conditions
/// with `=`, `#ignore: +-`, `δ = 25,7°`, `n = 2`, `ε` for nothing, subscripts. `X_n`, `X_{n-1}` and `X_0` are levels of
/// a recurrence and become a parameter, X(n); other subscripts make a name. Each of several axioms, `w: L,R`, is a
/// model. `shape X: modules` defines the drawing of a symbol. The turtle starts along +y unless `α0 = ...` changes it.
/// + turns left unless `turns: clockwise` changes it. / and \ roll as in the matrices of the Portuguese chapter:
/// opposite to cpfg.
[[nodiscard]] bool recognisesTextbook(std::string_view text);
[[nodiscard]] std::vector<DialectEntry> textbookEntries(std::string_view text);
[[nodiscard]] CpfgModel translateTextbook(std::string_view text, const std::string& entry, DialectReport& report);

/// The additions of a dialect to the notation.
struct TextbookExtension {
  bool isTurtlePainter = false;
};
[[nodiscard]] CpfgModel translateTextbookWith(std::string_view text, const std::string& entry,
                                              const TextbookExtension& extension, DialectReport& report);

}  // namespace espalier::language
