#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "server/access/token.h"

namespace espalier::command {
namespace {

struct TokenOptions {
  std::string name;
  std::vector<std::string> roles{"controller"};
  std::string expires;
  std::string output;  // file for the token; empty: standard output
};

/// Writes a secret into a new file that only this user can read. An error sentence, or nothing.
std::optional<std::string> writeSecret(const std::string& file, const std::string& text) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    return "the file '" + file + "' cannot be made, or is there already: give another name with -o";
  }
  const std::string line = text + "\n";
  const bool isWritten = ::write(descriptor, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const bool isClosed = ::close(descriptor) == 0;
  return isWritten && isClosed
             ? std::nullopt
             : std::optional("the token could not be written to '" + file + "': make room on the disk");
}

int runNewToken(const TokenOptions& options) {
  protocol::Roles roles;
  for (const std::string& name : options.roles) {
    roles.add(*protocol::roleOf(name));
  }
  const std::string text = server::drawTokenText();
  server::Token token = server::tokenOf(options.name, text, roles);
  if (!options.expires.empty()) {
    token.expires = server::readTime(options.expires);
    if (!token.expires) {
      printError("--expires '" + options.expires + "' is no time: write 2027-01-31 or 2027-01-31T12:00:00Z (UTC)");
      return kUsage;
    }
    if (token.isExpired(std::chrono::system_clock::now())) {
      printError("--expires '" + options.expires + "' is past: no server would accept the token. Give a later day");
      return kUsage;
    }
  }
  const std::string line = server::toText(token);
  // the server reads the line again when it starts
  if (const auto read = server::readToken(options.name, line); !read) {
    printError(read.error());
    return kUsage;
  }
  if (!options.output.empty()) {
    if (const auto problem = writeSecret(options.output, text)) {
      printError(*problem);
      return kFailure;
    }
  } else {
    std::printf("%s\n", text.c_str());
  }
  std::printf("%s = \"%s\"\n", options.name.c_str(), line.c_str());
  printNote(std::string(options.output.empty() ? "the first line is the token; it is shown only now. The second line"
                                               : "the line") +
            " belongs under [tokens] of the server's configuration");
  return kSuccess;
}

}  // namespace

void addToken(CLI::App& program, int& status) {
  const auto options = std::make_shared<TokenOptions>();
  CLI::App* token = program.add_subcommand("token", "Make tokens for clients of a server");
  token->require_subcommand(1);
  CLI::App* command = token->add_subcommand("new", "Draw a token, and print its line for the server's configuration");
  command->footer(
      "The server keeps the hash of a token only. Roles: a controller does everything, a viewer reads and watches, an\n"
      "environment offers itself. Examples:\n"
      "  espalier token new alice -o alice.token >> tokens.toml\n"
      "  espalier token new screen --role viewer --expires 2027-01-31\n"
      "  espalier connect HOST:4321 --token-file alice.token list");
  command->add_option("NAME", options->name, "Name of the token, for the server's log")->required();
  command->add_option("--role", options->roles, "controller, viewer or environment. May be repeated")
      ->check(CLI::IsMember({"controller", "viewer", "environment"}))
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--expires", options->expires,
                      "Day or time (UTC) when it ends: 2027-01-31, 2027-01-31T12:00:00Z");
  command->add_option("-o,--output", options->output, "New file for the token itself, readable by you only");
  command->callback([options, &status] { status = runNewToken(*options); });
}

}  // namespace espalier::command
