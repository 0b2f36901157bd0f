#pragma once

#include <span>

#include "environment/base/configuration.h"
#include "environment/base/length_unit.h"

namespace espalier::environment {

/// The configuration of a process whose defaults are in metres, for a world with another unit of length. Defaults of
/// keys that are not given are converted by the unit of their key ("length", "1/length", "mol/length^3", …); given
/// values stay. In metres, and with a null `unit`, whose size is unknown, nothing changes. O(keys).
[[nodiscard]] Configuration withDefaultLengths(Configuration configuration, std::span<const ConfigurationKey> keys,
                                               const LengthUnit* unit);

}  // namespace espalier::environment
