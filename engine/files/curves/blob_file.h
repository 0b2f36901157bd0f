#pragma once

#include "engine/files/data_file.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// Reads a blob field `.sdat` (FILES §10), line by line. What is wrong is a warning and left out.
[[nodiscard]] BlobField readBlobFile(const DataFile& file);

}  // namespace espalier::language
