#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <cstdio>
#include <string>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "server/language_server/language_server.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

int serveEditor() {
  server::DiskFileProvider files;
  server::LanguageServer editor(files);
  server::MessageCutter cutter;
  std::array<char, 65536> buffer{};
  while (!editor.hasEnded()) {
    if (const auto message = cutter.next()) {
      for (const std::string& answer : editor.receive(*message)) {
        const std::string text = server::framed(answer);
        std::fwrite(text.data(), 1, text.size(), stdout);
      }
      std::fflush(stdout);
      continue;
    }
    if (cutter.isBroken()) {
      printError(
          "standard input is not the Language Server Protocol: an editor starts this command, a person rarely does. "
          "docs/editors.md says how to set one up");
      return kFailure;
    }
    const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count <= 0) {
      break;  // the editor is gone
    }
    cutter.add({buffer.data(), static_cast<std::size_t>(count)});
  }
  return editor.isShutDown() ? kSuccess : kFailure;
}

}  // namespace

void addLanguageServer(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("language-server", "Help an editor with models (Language Server Protocol)");
  command->footer(
      "Editors start this command and talk to it over standard input and output. It checks models while you type,\n"
      "explains symbols, completes and renames names, and lays out texts. docs/editors.md shows how to set up Neovim\n"
      "and Visual Studio Code.");
  command->callback([&status] { status = serveEditor(); });
}

}  // namespace espalier::command
