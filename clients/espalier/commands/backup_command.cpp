#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "server/store/backup.h"

namespace espalier::command {
namespace {

struct BackupOptions {
  std::string folder;
  std::string file;
};

int statusOf(const std::optional<std::string>& problem) {
  if (problem) {
    printError(*problem);
    return kFailure;
  }
  return kSuccess;
}

}  // namespace

void addBackup(CLI::App& program, int& status) {
  const auto options = std::make_shared<BackupOptions>();
  CLI::App* command = program.add_subcommand("backup", "Copy a server's data folder into one file, while it runs");
  command->footer(
      "The copy holds all simulations, checkpoints and loaded models as they are at one moment. The server that uses "
      "the\n"
      "folder goes on. Traces are files of their own (FOLDER/traces) and not in the copy. Example:\n"
      "  espalier backup plants plants.backup");
  command->add_option("FOLDER", options->folder, "Folder that a server has as --data")->required();
  command->add_option("FILE", options->file, "New file for the copy")->required();
  command->callback([options, &status] { status = statusOf(server::backUpStore(options->folder, options->file)); });
}

void addRestore(CLI::App& program, int& status) {
  const auto options = std::make_shared<BackupOptions>();
  CLI::App* command = program.add_subcommand("restore", "Make a data folder from a copy that backup has made");
  command->footer(
      "The copy is checked first. FOLDER must hold no database, and no server may use it. Example:\n"
      "  espalier restore plants.backup plants2\n"
      "  espalier serve --data plants2");
  command->add_option("FILE", options->file, "File that `espalier backup` has made")->required();
  command->add_option("FOLDER", options->folder, "Data folder to make")->required();
  command->callback([options, &status] { status = statusOf(server::restoreStore(options->file, options->folder)); });
}

}  // namespace espalier::command
