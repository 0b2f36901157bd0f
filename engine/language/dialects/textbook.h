#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// The notation that chapters, lectures and papers print: `ω: F`, `p1: F → F[+F]F`, `→ (1/3)F` or `: 0.33`, conditions
/// with `=`, `#ignore: +-`, `δ = 25,7°`, `n = 2`, `ε` for nothing, subscripts. `X_n`, `X_{n-1}` and `X_0` are levels of
/// a recurrence and become a parameter, X(n); other subscripts make a name. Several axioms, `w: L,R`, are one model
/// each. `shape X: modules` says what a symbol looks like. The turtle starts along +y unless `α0 = ...` says otherwise
/// and + turns left unless `turns: clockwise` stands there; / and \ roll as the matrices of the Portuguese chapter say,
/// which is the other way round than in cpfg.
[[nodiscard]] bool recognisesTextbook(std::string_view text);
[[nodiscard]] std::vector<DialectEntry> textbookEntries(std::string_view text);
[[nodiscard]] CpfgModel translateTextbook(std::string_view text, const std::string& entry, DialectReport& report);

/// What a dialect adds to the notation.
struct TextbookExtension {
  bool isTurtlePainter = false;
};
[[nodiscard]] CpfgModel translateTextbookWith(std::string_view text, const std::string& entry,
                                              const TextbookExtension& extension, DialectReport& report);

}  // namespace espalier::language
