#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "engine/core/byte_source.h"

namespace espalier::server {

struct EnvironmentCheckOptions {
  std::string address;  // tcp://HOST:PORT or stdio:COMMAND
  std::chrono::milliseconds stepTimeout{60'000};
  std::string configurationJson;      // for environment.open; empty: none
  core::ByteSource* trace = nullptr;  // of a recorded run whose queries are put to it too; null: none
};

/// Talks to an environment without a simulation and tells the author what is right and what is not: description, shapes
/// and units, order independence, repeatability, numbers that are not finite, save and restore, latencies; and with a
/// trace whether it answers as the recorded one did. `print` receives one line for each finding. True when all is
/// right.
[[nodiscard]] bool checkEnvironment(const EnvironmentCheckOptions& options,
                                    const std::function<void(const std::string&)>& print);

}  // namespace espalier::server
