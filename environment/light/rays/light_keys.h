#pragma once

#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/process_entry.h"

namespace espalier::environment {

inline constexpr std::string_view kLightSummary =
    "Sun and sky on the organs of all plants, by rays, with bounces and bands.";

/// The errors of keys that have the right kind and range: numbers that do not fit the bands, surfaces that scatter
/// more than they get, a ground without a plot.
[[nodiscard]] std::vector<core::Diagnostic> checkLight(const Configuration& configuration);

/// The process of a configuration, or its errors.
[[nodiscard]] ProcessOrErrors makeLight(const Configuration& configuration);

}  // namespace espalier::environment
