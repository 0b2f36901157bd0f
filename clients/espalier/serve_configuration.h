#pragma once

#include <optional>
#include <string>

#include "server/remote/limits.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Reads the configuration of `serve`, TOML or INI: the command's long options without their dashes, and a section
/// [limits]. The command line wins. Call it after the options of the command are read and before they are used. Returns
/// an error sentence when the file cannot be read or has an unknown key.
[[nodiscard]] std::optional<std::string> readServeConfiguration(CLI::App& command, const std::string& file,
                                                                server::ServerLimits& limits);

/// The effective values in the form that readServeConfiguration reads. A token is not shown.
[[nodiscard]] std::string serveConfigurationText(const CLI::App& command, const server::ServerLimits& limits);

}  // namespace espalier::command
