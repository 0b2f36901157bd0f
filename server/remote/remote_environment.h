#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <variant>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

struct RemoteEnvironmentOptions {
  std::chrono::milliseconds connectTimeout{5'000};
  std::chrono::milliseconds stepTimeout{60'000};
  bool isAbsenceTolerated = false;  // a peer that is away now may be there when it is asked
  bool isTextOnly = false;          // no binary blocks, though the environment may take them
  std::string configurationJson;    // sent when a simulation opens it: an object as text; empty: none
};

/// An environment in another process, spoken to with the protocol: `tcp://HOST:PORT` and `unix:PATH` are dialled,
/// `stdio:COMMAND` is spawned by the shell and spoken to on its standard input and output (its standard error passes
/// through). Bitwise the same plant as in-process. Returns the process, or a sentence that says what is wrong and what
/// to do.
[[nodiscard]] std::variant<std::unique_ptr<turtle::EnvironmentProcess>, std::string> connectRemoteEnvironment(
    const std::string& address, const RemoteEnvironmentOptions& options);

}  // namespace espalier::server
