#pragma once

#include <string>

#include "engine/language/inference/d0l_inference.h"

namespace espalier::language {

/// A system as the text of a model: its axiom is the first string, its derivation length the number of steps. Symbols
/// that stay as they are need no production. `comment` goes in front, line by line. A symbol that the language has not
/// (a letter outside ASCII) makes a text that does not compile.
[[nodiscard]] std::string inferredModelText(const StepStrings& steps, const D0lSystem& system,
                                            const std::string& comment);

/// The productions one a line, "a → ba", as papers print them; ε for nothing. Symbols that stay as they are are left
/// out.
[[nodiscard]] std::string inferredProductions(const StepStrings& steps, const D0lSystem& system);

/// How systems differ: a line for each symbol that has not the same successor in all of them, "A: AB, or ABA".
[[nodiscard]] std::string inferredDifferences(const StepStrings& steps, const std::vector<D0lSystem>& systems);

}  // namespace espalier::language
