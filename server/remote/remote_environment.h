#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

struct RemoteEnvironmentOptions {
  std::chrono::milliseconds connectTimeout{5'000};
  std::chrono::milliseconds stepTimeout{60'000};
  bool isAbsenceTolerated = false;  // a peer that is away now may be there when it is asked
  bool keepsState = false;          // asks for the state after each step, so that it is known when the environment dies
  bool isTextOnly = false;          // no binary blocks, though the environment may take them
  std::string configurationJson;    // sent when a simulation opens it: an object as text; empty: none
};

/// An environment in another process, reached with the protocol. `tcp://HOST:PORT` and `unix:PATH` are connected to.
/// `stdio:COMMAND` is started by the shell and answers on its standard output; its standard error passes through. It
/// gives bitwise the same plant as a process inside the program. Returns the process, or an error sentence with a
/// remedy.
[[nodiscard]] tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::string> connectRemoteEnvironment(
    const std::string& address, const RemoteEnvironmentOptions& options);

}  // namespace espalier::server
