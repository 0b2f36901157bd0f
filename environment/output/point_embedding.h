#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/streams.h"
#include "engine/files/points/point_cloud.h"
#include "environment/environment_entries.h"

namespace espalier::environment {

/// How the points of a file come into the world: (p − origin) · scale. Points of a file that says what is up are turned
/// so that east is x, up is y and south is z; `keepsAxes` leaves them as they are.
struct PointPlacement {
  core::Vec3 origin;
  double scale = 1.0;
  bool keepsAxes = false;
};

/// Places all points of a cloud. O(points).
void placePoints(files::PointCloud& cloud, const PointPlacement& placement);

/// Replaces `"pointFile": NAME` (LAS or PLY, looked for beside `file`) in the configuration of an entry by its points:
/// attractors of `attractors` (`pointStrength`), markers of `colonization`, solid spheres of the other processes with
/// obstacles (`pointRadius`). `pointOrigin`, `pointScale`, `pointAxes` place them, `pointSpacing` keeps the first point
/// in each cube, `pointClasses` those classes of LAS. Entries without the key stay as they are. A problem is returned.
/// O(points).
[[nodiscard]] std::optional<core::Diagnostic> embedPointFile(EnvironmentEntry& entry, const std::string& file,
                                                             core::FileProvider& files);

}  // namespace espalier::environment
