#pragma once

#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/process_entry.h"

namespace espalier::environment {

inline constexpr std::string_view kLightVoxelsSummary =
    "Light in voxels: through a turbid medium of leaves, or by propagated shadows.";

/// The errors of keys that have the right kind and range: too many voxels, keys that exclude each other, bands that do
/// not fit.
[[nodiscard]] std::vector<core::Diagnostic> checkLightVoxels(const Configuration& configuration);

/// The process of a configuration, or its errors.
[[nodiscard]] ProcessOrErrors makeLightVoxels(const Configuration& configuration);

}  // namespace espalier::environment
