#pragma once

#include <optional>

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files {

/// Reads a contour (docs/model-files.md, 8): `cver 1 1` to `cver 1 3`, or the form without a version. The
/// file's `samples:` are ignored. A mistake gives a warning and no contour: the caller then uses the circle.
[[nodiscard]] std::optional<Contour> readContourFile(const DataFile& file, int id);

}  // namespace espalier::files
