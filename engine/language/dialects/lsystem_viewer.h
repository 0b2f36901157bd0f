#pragma once

#include <string>
#include <string_view>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// The `.lsv` files of L-System Viewer (Santos & Pereira): `generations`, `scale` (of a step, from one generation to
/// the next; also a fraction), `color`, `heading` (degrees from +x), `origin`, `step`, `angle`, `axiom` and `prule`,
/// one command a line as `command value`, `command: value` or `command = value`. The publication does not show the
/// punctuation.
[[nodiscard]] bool recognisesLsystemViewer(std::string_view text);
[[nodiscard]] CpfgModel translateLsystemViewer(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
