#pragma once

#include <string>
#include <string_view>

#include "engine/language/dialects/translation.h"

namespace espalier::language {

/// Files of Lparser (Laurens Lapré), `.ls`: symbols of one character with at most one number, deterministic and without
/// contexts. In the old form the values stand in a fixed order, one to a line: recursion depth, angle, thickness in per
/// cent of the length, axiom, then rules `X=...` up to `@`. In the new form words name them: `recursion`, `angle`,
/// `thickness`, `min_thickness`, `shape`, `switch_yz`, `axiom`, `rule`. The turtle starts upwards (Lparser's +z is
/// Espalier's +y).
[[nodiscard]] bool recognisesLparser(std::string_view text);
[[nodiscard]] CpfgModel translateLparser(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
