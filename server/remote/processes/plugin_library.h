#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "engine/turtle/environment_process.h"

namespace espalier::server {

/// Loads a plug-in (environment/plugin.h) from a shared library and makes a process of it. The library runs inside this
/// program, with its rights: only what the person at the command line names is loaded. One that takes longer than
/// `stepTimeout`, throws or answers with what is no finite number fails the step (supervised_process.h). Returns the
/// process, or a sentence that says what is wrong and what to do.
[[nodiscard]] std::variant<std::unique_ptr<turtle::EnvironmentProcess>, std::string> loadPluginProcess(
    const std::string& library, std::string_view configurationJson,
    std::chrono::milliseconds stepTimeout = std::chrono::seconds(60));

}  // namespace espalier::server
