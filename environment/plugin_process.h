#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/turtle/environment_process.h"
#include "environment/plugin.h"

namespace espalier::environment {

/// A plug-in's table as a process. The process keeps `library`, a handle whose deleter unloads it, as long as it lives.
/// The text of the configuration must be a JSON object or empty. Returns the process, or a sentence: an unknown
/// version, a missing function, or the plug-in's reason to refuse the configuration.
[[nodiscard]] tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::string> makePluginProcess(
    const espalier_plugin& plugin, std::shared_ptr<void> library, std::string_view configurationJson);

}  // namespace espalier::environment
