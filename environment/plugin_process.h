#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "engine/turtle/environment_process.h"
#include "environment/plugin.h"

namespace espalier::environment {

/// A plug-in's table as a process; `library` is kept as long as the process lives (a handle whose deleter unloads it).
/// The text of the configuration must be a JSON object or empty. Returns the process, or a sentence: an unknown
/// version, a missing function, or why the plug-in refuses the configuration.
[[nodiscard]] std::variant<std::unique_ptr<turtle::EnvironmentProcess>, std::string> makePluginProcess(
    const espalier_plugin& plugin, std::shared_ptr<void> library, std::string_view configurationJson);

}  // namespace espalier::environment
