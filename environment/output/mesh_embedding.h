#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"
#include "environment/environment_entries.h"

namespace espalier::environment {

/// Replaces `"meshFile": NAME` (an OBJ, GLB or glTF file, looked for beside `file`) in the configuration of an entry by
/// the mesh itself, as `vertices` and `triangles`, so that a configuration is complete wherever it is sent. Entries
/// without the key stay as they are. A problem with the file is returned. O(mesh).
[[nodiscard]] std::optional<core::Diagnostic> embedMeshFile(EnvironmentEntry& entry, const std::string& file,
                                                            core::FileProvider& files);

}  // namespace espalier::environment
