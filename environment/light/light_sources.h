#pragma once

#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

/// The problems of the rows x, y, z, weight of a process's key `sources`: a negative weight, no light at all, or, where
/// x, y, z is a direction, one without length. Empty: none.
[[nodiscard]] std::vector<core::Diagnostic> problemsOfSources(std::string_view process, const ConfigurationRows& rows,
                                                              bool areDirections);

}  // namespace espalier::environment
