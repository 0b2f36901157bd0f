#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Bytes that an environment holds between steps, by what it has taken and given back in its calls.
using EnvironmentBytes = std::atomic<std::int64_t>;

/// The process with its memory counted in `bytes`; null stays null. The memory of its construction is there already.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> countMemory(
    std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<EnvironmentBytes> bytes);

}  // namespace espalier::server
