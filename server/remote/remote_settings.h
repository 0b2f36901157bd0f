#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "engine/turtle/environment_process.h"
#include "server/remote/failure_policy.h"

namespace espalier::server {

/// What is done when an environment in another process fails: `fail`, `keep` or `fallback:NAME` of a built-in.
struct RemotePolicy {
  bool isTolerant = false;                               // keep or fallback
  std::unique_ptr<turtle::EnvironmentProcess> fallback;  // null: none

  /// The process with the policy around it; `sink` hears of its failures.
  [[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> around(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                                   FailureSink sink);
};

/// The policy of those words, or what is wrong with them.
[[nodiscard]] std::variant<RemotePolicy, std::string> readRemotePolicy(const std::string& words);

/// What an entry for an environment in another process says besides where it is.
struct RemoteSettings {
  RemotePolicy policy;
  std::optional<std::chrono::milliseconds> stepTimeout;
  std::string configurationJson;  // for environment.open; empty: none
};

struct RemoteSettingProblem {
  std::string key;
  std::string message;
};

/// Reads the members `policy`, `timeoutMilliseconds` and `configuration` of an entry's JSON. `policy` is the one when
/// there is none.
[[nodiscard]] std::variant<RemoteSettings, RemoteSettingProblem> readRemoteSettings(const std::string& entryJson,
                                                                                    const std::string& policy = "fail");

}  // namespace espalier::server
