#pragma once

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::files {

/// Reads a blob field `.sdat` (docs/model-files.md, 10) line by line. A wrong line gives a warning and is
/// ignored.
[[nodiscard]] BlobField readBlobFile(const DataFile& file);

}  // namespace espalier::files
