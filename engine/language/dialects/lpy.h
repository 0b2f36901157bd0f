#pragma once

#include <string>
#include <string_view>

#include "engine/language/dialects/translation.h"

namespace espalier::language {

/// The part of L-Py's language (`.lpy`) that needs no Python objects: constants, `module`, `Axiom:`, `derivation
/// length:`, `production:`, `decomposition:`, `interpretation:`, contexts, `-->`, rules as indented blocks with
/// `produce`, `nproduce`, `if`, `for ... in range(...)` with constant bounds, and numbers that Start, StartEach,
/// EndEach and End assign. Strings are those of L-Py. L-Py's radii become diameters in the drawing only, and its z
/// axis, upwards, is Espalier's y axis.
[[nodiscard]] bool recognisesLpy(std::string_view text);
[[nodiscard]] CpfgModel translateLpy(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
