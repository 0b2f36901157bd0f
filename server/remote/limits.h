#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/limits.h"

namespace espalier::server {

/// Bounds of a server. Each has one name (limitEntries): on the command line, in a configuration, on the wire and in
/// the error it causes.
struct ServerLimits {
  std::uint64_t lineBytes = 64'000'000;
  std::uint64_t helloBytes = 65'536;            // of a line or message before the peer has said hello
  std::uint64_t decodingBytes = 1'000'000'000;  // of all messages of all peers that have come and are not decoded yet
  std::uint64_t blockBytes = 256'000'000;       // raw bytes of one message, for peers that agreed on binary blocks
  std::uint64_t outboxBytes = 256'000'000;      // per session; a slow viewer is moved to the latest key frame instead
  std::uint64_t streamBytes = 1'000'000'000;    // of a simulation, kept to tell its viewers differences
  std::uint32_t sessions = 1'000;
  std::uint32_t waitingConnections = 1'000;   // of one side (protocol, HTTP) whose peers have not said hello
  std::uint32_t connectionsPerAddress = 500;  // but not from this machine; 0: no bound
  std::uint32_t simulations = 10'000;
  std::uint32_t simulationsPerSession = 1'000;  // that it made, as long as they exist
  std::uint32_t streamsPerSession = 100;
  std::uint32_t offersPerSession = 100;
  std::uint32_t requestsPerSession = 1'000;  // in progress at a time
  std::uint32_t handshakeMilliseconds = 10'000;
  std::uint32_t environmentConnectMilliseconds = 5'000;
  std::uint32_t environmentStepMilliseconds = 60'000;
  std::uint32_t heartbeatMilliseconds = 30'000;   // of silence until a peer that agreed to it is asked; 0: never
  std::uint64_t storeBytes = 0;                   // of the data folder's database; 0: as much as the disk has
  std::uint64_t traceBytes = 0;                   // of the traces in the data folder; 0: as much as the disk has
  std::uint64_t savedModelBytes = 1'000'000'000;  // of the models that clients have saved; 0: as much as the disk has
  std::uint64_t memoryBytes = 0;         // of all accounts together; 0: four fifths of what the process may have
  std::uint64_t accountMemoryBytes = 0;  // of one account; 0: as the server
  std::uint64_t accountSimulations = 0;  // the same
  std::uint64_t accountStreams = 0;      // the same
  std::uint64_t accountTraceBytes = 0;   // the same
  std::uint64_t accountCpuSeconds = 0;   // since the server was started; 0: no bound
  std::uint32_t callSeconds = 600;       // of computing without a completed step; 0: no bound
  /// The limits of each simulation. A server has many of them, so a string may take 4 GB, not 16 GB as on the command
  /// line.
  core::Limits simulation{.maximumModules = 200'000'000, .maximumStringBytes = 4'000'000'000};
};

/// One limit by name.
struct LimitEntry {
  std::string_view name;
  std::uint64_t minimum;     // smallest value that makes sense
  std::uint64_t maximum;     // largest that fits
  std::string_view meaning;  // for people, with the unit
  std::uint64_t (*get)(const ServerLimits&);
  void (*set)(ServerLimits&, std::uint64_t);
  bool isOfSimulation = false;  // of each simulation: also a limit of a program that runs one
};

/// All limits, in the order in which they are listed.
[[nodiscard]] std::span<const LimitEntry> limitEntries();

/// Null: there is none of that name.
[[nodiscard]] const LimitEntry* findLimit(std::string_view name);

/// The limit that a message of the engine names: "(limit modules)". Null: none.
[[nodiscard]] const LimitEntry* limitNamedIn(std::string_view message);

/// Sets a limit. An error sentence for an unknown name or a value out of range.
[[nodiscard]] std::optional<std::string> setLimit(ServerLimits& limits, std::string_view name, std::uint64_t value);

/// The same from NAME=NUMBER, as --limit has it.
[[nodiscard]] std::optional<std::string> setLimit(ServerLimits& limits, std::string_view assignment);

}  // namespace espalier::server
