#pragma once

#include <optional>
#include <string>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes a CSV (RFC 4180, with a header) of every module: plant, module (its index), symbol, parameters (separated by
/// `;`), x y z, hx hy hz, lx ly lz, ux uy uz, width, colour: the turtle after it, in world units, empty for what was
/// cut off; order (open brackets) and parent (index of the module that it grows from, empty for the first).
[[nodiscard]] std::optional<std::string> writeModuleTable(const ExportInput& input, const ExportTarget& target);

/// Writes the strings, a line for each plant, as `derive` prints them and `--from` reads them.
[[nodiscard]] std::optional<std::string> writeStrings(const ExportInput& input, const ExportTarget& target);

}  // namespace espalier::turtle
