#pragma once

#include <optional>

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// Reads a contour (FILES §8): `cver 1 1` to `cver 1 3`, or the form without a version. The file's `samples:` are
/// ignored. What is wrong is a warning and gives nothing: the circle is then used.
[[nodiscard]] std::optional<Contour> readContourFile(const DataFile& file, int id);

}  // namespace espalier::language
