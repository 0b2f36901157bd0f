#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Makes a fresh process for each simulation that opens one.
using ProcessFactory = std::function<std::unique_ptr<turtle::EnvironmentProcess>()>;

/// Serves a process over the protocol on a TCP address until SIGINT or SIGTERM. Calls `onListening` with the port when
/// ready. Returns an error sentence (port in use, address unknown), or nothing after a clean stop.
[[nodiscard]] std::optional<std::string> hostEnvironment(const std::string& host, std::uint16_t port,
                                                         const ProcessFactory& factory,
                                                         const std::function<void(std::uint16_t)>& onListening);

/// The same on standard input and output, until the input ends.
[[nodiscard]] std::optional<std::string> hostEnvironmentOnStdio(const ProcessFactory& factory);

}  // namespace espalier::server
