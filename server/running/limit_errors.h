#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "protocol/errors.h"

namespace espalier::server {

/// The error of a call that computed too long. `outcome` says how things are now. `step` is the last completed step.
[[nodiscard]] protocol::Error callSecondsError(std::uint64_t bound, const std::string& outcome,
                                               std::optional<std::uint64_t> step);

}  // namespace espalier::server
