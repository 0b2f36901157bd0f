#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "engine/turtle/environment_process.h"
#include "server/remote/failure_policy.h"

namespace espalier::server {

/// The reaction to a failure of an environment in another process: `fail`, `keep` or `fallback:NAME` of a built-in.
struct RemotePolicy {
  bool isTolerant = false;                               // keep or fallback
  std::unique_ptr<turtle::EnvironmentProcess> fallback;  // null: none

  /// The process with the policy around it; `sink` receives its failures.
  [[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> around(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                                   FailureSink sink);
};

/// The policy of those words, or an error sentence.
[[nodiscard]] tl::expected<RemotePolicy, std::string> readRemotePolicy(const std::string& words);

/// The settings of an entry for an environment in another process, besides its address.
struct RemoteSettings {
  RemotePolicy policy;
  std::optional<std::chrono::milliseconds> stepTimeout;
  std::string configurationJson;  // for environment.open; empty: none
};

struct RemoteSettingProblem {
  std::string key;
  std::string message;
};

/// Reads the members `policy`, `timeoutMilliseconds` and `configuration` of an entry's JSON. `policy` is
/// used when the entry has none.
[[nodiscard]] tl::expected<RemoteSettings, RemoteSettingProblem> readRemoteSettings(const std::string& entryJson,
                                                                                    const std::string& policy = "fail");

}  // namespace espalier::server
