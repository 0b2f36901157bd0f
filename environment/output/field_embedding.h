#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"
#include "environment/environment_entries.h"

namespace espalier::environment {

/// Replaces `"fieldFile": NAME` (.vti, or .raw with its header, looked for beside `file`) in the configuration of an
/// entry by the field itself, with which the process begins: of `soil-water` the pressure head, as `initialHeads`; of
/// `light-voxels` the leaf area density of plants that are not simulated, as `leafAreaDensity`. The file also gives the
/// cells, their size and the position of the box, which the entry may not contradict. Entries without the key stay as
/// they are. A problem with the file is returned. O(cells).
[[nodiscard]] std::optional<core::Diagnostic> embedFieldFile(EnvironmentEntry& entry, const std::string& file,
                                                             core::FileProvider& files);

}  // namespace espalier::environment
