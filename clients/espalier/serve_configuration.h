#pragma once

#include <optional>
#include <string>

#include "server/remote/limits.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Reads the configuration of `serve`, TOML or INI: the command's long options without their dashes, and a section
/// [limits]. What the command line says wins. Call it while the command's options have been read and not used. An error
/// sentence for what cannot be read or is not known.
[[nodiscard]] std::optional<std::string> readServeConfiguration(CLI::App& command, const std::string& file,
                                                                server::ServerLimits& limits);

/// The effective values in the form that readServeConfiguration reads. A token is not shown.
[[nodiscard]] std::string serveConfigurationText(const CLI::App& command, const server::ServerLimits& limits);

}  // namespace espalier::command
