#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Receives each use of a policy: the step (completed steps before it) and a whole sentence.
using FailureSink = std::function<void(std::uint64_t step, const std::string& message)>;

/// An environment whose failures do not fail the step. The modules keep what they sent (`fallback` null), or the
/// built-in `fallback` answers. Every step asks the environment first, so an environment that comes back is used again.
/// `sink` receives each failure. A failure to open, and a state that cannot be restored, count too.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> withFailurePolicy(
    std::unique_ptr<turtle::EnvironmentProcess> process, std::unique_ptr<turtle::EnvironmentProcess> fallback,
    FailureSink sink);

}  // namespace espalier::server
