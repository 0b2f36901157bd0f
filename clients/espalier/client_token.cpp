#include "clients/espalier/client_token.h"

#include <CLI/CLI.hpp>
#include <fstream>

namespace espalier::command {

void addClientToken(CLI::App& command, std::string& token) {
  CLI::Option* const text = command.add_option("--token", token, "Token of the server, if the server needs one");
  const auto read = [&token](const std::string& file) {
    std::ifstream stream(file);
    if (!std::getline(stream, token) || token.empty()) {
      throw CLI::ValidationError("--token-file", "'" + file + "' cannot be read, or its first line is empty");
    }
  };
  command
      .add_option_function<std::string>(
          "--token-file", read, "File with the token in its first line; other users of the machine cannot see it")
      ->excludes(text);
}

}  // namespace espalier::command
