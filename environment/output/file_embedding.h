#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"
#include "environment/environment_entries.h"

namespace espalier::environment {

/// Replaces the files that the configuration of an entry names by what is in them: `meshFile`, `pointFile` and
/// `fieldFile` (mesh_embedding.h, point_embedding.h, field_embedding.h), so that
/// a configuration is complete wherever it is sent. A problem with a file is returned.
[[nodiscard]] std::optional<core::Diagnostic> embedFiles(EnvironmentEntry& entry, const std::string& file,
                                                         core::FileProvider& files);

}  // namespace espalier::environment
