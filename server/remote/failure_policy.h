#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// What was done about an environment that failed: the step (completed steps before it) and a whole sentence.
using FailureSink = std::function<void(std::uint64_t step, const std::string& message)>;

/// An environment whose failures do not fail the step: the modules keep what they sent, or a built-in process answers
/// in its place. Every step asks the environment first, so that one that comes back is used again. `fallback` null:
/// keep. `sink` hears of each failure. Not opening, and a state that cannot be restored, are failures like any other.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> withFailurePolicy(
    std::unique_ptr<turtle::EnvironmentProcess> process, std::unique_ptr<turtle::EnvironmentProcess> fallback,
    FailureSink sink);

}  // namespace espalier::server
