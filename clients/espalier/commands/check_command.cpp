#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/forest_file.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

int check(ModelOptions& options) {
  server::DiskFileProvider files;
  if (const auto forest = forestFileOf(options.model)) {
    if (!loadForest(*forest, options, files)) {
      return kFailure;
    }
    std::printf("%s: no errors\n", forest->c_str());
    return kSuccess;
  }
  FolderSettings folder;
  const std::shared_ptr<const language::Program> program = loadProgram(options, files, &folder);
  if (!program) {
    return kFailure;
  }
  // a check connects to no other process
  const bool isRemote = options.environment.rfind("tcp://", 0) == 0 || options.environment.rfind("stdio:", 0) == 0;
  if (!isRemote) {
    std::optional<LoadedEnvironment> environment;
    if (!options.environment.empty()) {
      environment = loadEnvironment(options.environment, options.mode(), options.isQuiet, files, options.remote);
      if (!environment) {
        return kFailure;
      }
    }
    if (!warnAboutUnansweredQueries(*program, environment ? &*environment : nullptr, options.isQuiet,
                                    options.remote.isStrict)) {
      return kFailure;
    }
  }
  std::printf("%s: no errors\n", program->modelFile.c_str());
  return kSuccess;
}

}  // namespace

void addCheck(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("check", "Read a model and list its errors and warnings");
  command->footer(
      "Prints every error and warning on standard error with its place and a hint. Derives nothing.\n"
      "Exit status 1 when there is an error, with --strict also when there is a warning.\n"
      "Example: espalier check tree.l");
  auto options = std::make_shared<ModelOptions>();
  addReadingOptions(*command, *options, true);
  command->callback([options, &status] { status = check(*options); });
}

}  // namespace espalier::command
