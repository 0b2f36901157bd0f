#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Loads a plug-in (environment/plugin.h) from a shared library and makes a process of it. The library runs inside this
/// program, with its rights: only a library named on the command line is loaded. A plug-in that takes longer than
/// `stepTimeout`, throws, or answers with a number that is not finite fails the step (supervised_process.h). Returns
/// the process, or an error sentence with a remedy.
[[nodiscard]] tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::string> loadPluginProcess(
    const std::string& library, std::string_view configurationJson,
    std::chrono::milliseconds stepTimeout = std::chrono::seconds(60));

}  // namespace espalier::server
