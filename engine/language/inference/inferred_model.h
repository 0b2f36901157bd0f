#pragma once

#include <string>

#include "engine/language/inference/d0l_inference.h"

namespace espalier::language {

/// A system as the text of a model: its axiom is the first string, its derivation length the number of steps. Symbols
/// that never change need no production. `comment` comes first, line by line. A symbol outside ASCII makes a text that
/// does not compile.
[[nodiscard]] std::string inferredModelText(const StepStrings& steps, const D0lSystem& system,
                                            const std::string& comment);

/// The productions one a line, "a → ba", as papers print them; ε for nothing. Symbols that never change have no
/// line.
[[nodiscard]] std::string inferredProductions(const StepStrings& steps, const D0lSystem& system);

/// The differences of systems: a line for each symbol with different successors, "A: AB, or ABA".
[[nodiscard]] std::string inferredDifferences(const StepStrings& steps, const std::vector<D0lSystem>& systems);

}  // namespace espalier::language
