#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Makes a fresh process for each simulation that opens one.
using ProcessFactory = std::function<std::unique_ptr<turtle::EnvironmentProcess>()>;

/// Where an environment is served.
struct HostAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;          // 0: a free one
  bool isInsecureAllowed = false;  // an address that other machines reach: without encryption and without a token
  std::chrono::milliseconds firstMessage{10'000};  // time until a connection has sent its first message
  std::uint64_t heldBytes = 1'000'000'000;         // of all messages that have come in part
  std::size_t connections = 0;                     // at a time; 0: as many as there are descriptors for
  std::uint64_t memoryBytes = 0;  // of all simulations; 0: four fifths of the memory that the process may have
};

/// Serves a process over the protocol on a TCP address until SIGINT or SIGTERM. Calls `onListening` with the port when
/// ready. Returns an error sentence (port in use, address unknown or not loopback), or nothing after a clean stop.
[[nodiscard]] std::optional<std::string> hostEnvironment(const HostAddress& address, const ProcessFactory& factory,
                                                         const std::function<void(std::uint16_t)>& onListening);

/// The same on standard input and output, until the input ends.
[[nodiscard]] std::optional<std::string> hostEnvironmentOnStdio(const ProcessFactory& factory);

}  // namespace espalier::server
