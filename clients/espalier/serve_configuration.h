#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/server.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Reads the configuration of `serve`, TOML or INI: the command's long options without their dashes, and the sections
/// [limits], [spawn] and [tokens]. The command line wins. Call it after the options of the command are read and before
/// they are used. Returns an error sentence when the file cannot be read, has an unknown key or a wrong value.
[[nodiscard]] std::optional<std::string> readServeConfiguration(CLI::App& command, const std::string& file,
                                                                server::ServerOptions& options);

/// Adds the tokens of the section [tokens] of a configuration; nothing else is used. An error sentence as above.
[[nodiscard]] std::optional<std::string> readConfiguredTokens(const std::string& file,
                                                              std::vector<server::Token>& tokens);

/// The limits of the section [limits] of a configuration. The rest is not used, but an unknown key in it is an error,
/// too, as when a server starts. `hasLimits`: without the section the file counts as damaged. An error sentence as
/// above.
[[nodiscard]] std::optional<std::string> readConfiguredLimits(const CLI::App& command, const std::string& file,
                                                              bool hasLimits, server::ServerLimits& limits);

/// Whether a configuration sets a limit.
[[nodiscard]] bool setsLimits(const std::string& file);

/// The items of a configuration beside limits and tokens, by name ("listen", "spawn.light"): what a server reads when
/// it starts. None when the file cannot be read.
[[nodiscard]] std::map<std::string, std::vector<std::string>> readStartItems(const std::string& file);

/// The effective values in the form that readServeConfiguration reads. Of tokens only the hashes are shown.
[[nodiscard]] std::string serveConfigurationText(const CLI::App& command, const server::ServerOptions& options);

}  // namespace espalier::command
