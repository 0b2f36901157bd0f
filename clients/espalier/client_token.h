#pragma once

#include <string>

namespace CLI {
class App;
}

namespace espalier::command {

/// Adds --token and --token-file to a command that connects to a server. `token` receives the text and outlives
/// parsing.
void addClientToken(CLI::App& command, std::string& token);

}  // namespace espalier::command
