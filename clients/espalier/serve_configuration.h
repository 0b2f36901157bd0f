#pragma once

#include <map>
#include <optional>
#include <string>
#include <tl/expected.hpp>
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

/// The parts of its configuration that a server reads again while it runs.
struct ConfiguredAgain {
  std::vector<server::Token> tokens;                      // of the section [tokens]
  server::ServerLimits limits;                            // of the section [limits]
  std::map<std::string, std::vector<std::string>> items;  // as readStartItems()
};

/// Reads a configuration again, once, so that tokens and limits are of one state of the file. An unknown key is an
/// error as when a server starts. `hasLimits`: without the section [limits] the file counts as damaged. An error
/// sentence as above.
[[nodiscard]] tl::expected<ConfiguredAgain, std::string> readConfigurationAgain(const CLI::App& command,
                                                                                const std::string& file,
                                                                                bool hasLimits);

/// Whether a configuration sets a limit.
[[nodiscard]] bool setsLimits(const std::string& file);

/// The items of a configuration beside limits and tokens, by name ("listen", "spawn.light"): what a server reads when
/// it starts. None when the file cannot be read.
[[nodiscard]] std::map<std::string, std::vector<std::string>> readStartItems(const std::string& file);

/// The effective values in the form that readServeConfiguration reads. Of tokens only the hashes are shown.
[[nodiscard]] std::string serveConfigurationText(const CLI::App& command, const server::ServerOptions& options);

}  // namespace espalier::command
