#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"
#include "engine/turtle/field.h"
#include "environment/environment_entries.h"
#include "server/remote/terrain/geotiff.h"

namespace espalier::server {

/// Replaces `"terrainFile": NAME` (GeoTIFF, looked for beside `file`) in the configuration of an entry by its heights,
/// as `heightField` and `heightFieldExtent`: east is x, up is y, south is z. `terrainOrigin` (east, north, height of
/// the point that comes to the origin) and `terrainScale` place them. Entries without the key stay as they are. A
/// problem is returned. O(heights).
[[nodiscard]] std::optional<core::Diagnostic> embedTerrainFile(environment::EnvironmentEntry& entry,
                                                               const std::string& file, core::FileProvider& files);

/// The same, then all other files that a configuration names (environment/output/file_embedding.h).
[[nodiscard]] std::optional<core::Diagnostic> embedAllFiles(environment::EnvironmentEntry& entry,
                                                            const std::string& file, core::FileProvider& files);

/// The heights as a field of one layer, x to the east and y to the north.
[[nodiscard]] turtle::Field heightsOf(const Terrain& terrain);

}  // namespace espalier::server
