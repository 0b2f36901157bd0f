#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/forest_file.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct ModelCheckOptions {
  ModelOptions model;
  std::vector<std::string> others;  // further models
  bool isList = false;
};

// the model without an error, or null
std::shared_ptr<const language::Program> checkOne(ModelOptions& options, core::FileProvider& files) {
  server::FolderSettings folder;
  std::shared_ptr<const language::Program> program = loadProgram(options, files, &folder);
  // a check connects to no other process
  const bool isRemote = options.environment.rfind("tcp://", 0) == 0 || options.environment.rfind("stdio:", 0) == 0;
  if (!program || isRemote) {
    return program;
  }
  std::optional<LoadedEnvironment> environment;
  if (!options.environment.empty()) {
    environment = loadEnvironment(options.environment, options.mode(), options.isQuiet, files, options.remote);
    if (!environment || !warnAboutUnaskedEnvironment(*program, options.isQuiet, options.remote.isStrict)) {
      return nullptr;
    }
  }
  const bool isRight = warnAboutUnansweredQueries(*program, environment ? &*environment : nullptr, options.isQuiet,
                                                  options.remote.isStrict);
  return isRight ? program : nullptr;
}

int checkEntries(const ModelOptions& options, const std::vector<std::string>& entries, core::FileProvider& files) {
  std::string wrong;
  std::size_t wrongCount = 0;
  for (const std::string& entry : entries) {
    ModelOptions one = options;
    one.model += ":" + entry;
    if (!checkOne(one, files)) {
      wrong += (wrong.empty() ? "" : ", ") + entry;
      ++wrongCount;
    }
  }
  std::printf("%s: %zu models, ", options.model.c_str(), entries.size());
  if (wrongCount == 0) {
    std::printf("no errors\n");
    return kSuccess;
  }
  std::printf("%zu with errors: %s\n", wrongCount, wrong.c_str());
  return kFailure;
}

int checkModel(ModelCheckOptions options, core::FileProvider& files) {
  const std::vector<std::string> entries = modelEntries(options.model, files);
  if (options.isList) {
    for (const std::string& entry : entries) {
      std::printf("%s:%s\n", options.model.model.c_str(), entry.c_str());
    }
    if (entries.empty()) {
      std::printf("%s\n", options.model.model.c_str());
    }
    return kSuccess;
  }
  if (!entries.empty()) {
    return checkEntries(options.model, entries, files);
  }
  if (const auto forest = forestFileOf(options.model.model)) {
    if (!loadForest(*forest, options.model, files)) {
      return kFailure;
    }
    std::printf("%s: no errors\n", forest->c_str());
    return kSuccess;
  }
  const std::shared_ptr<const language::Program> program = checkOne(options.model, files);
  if (!program) {
    return kFailure;
  }
  std::printf("%s: no errors\n", program->modelFile.c_str());
  return kSuccess;
}

int check(const ModelCheckOptions& options) {
  server::DiskFileProvider files;
  int status = checkModel(options, files);
  for (const std::string& other : options.others) {
    ModelCheckOptions one = options;
    one.model.model = other;
    status = std::max(status, checkModel(std::move(one), files));
  }
  return status;
}

}  // namespace

void addCheck(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("check", "Read a model and list its errors and warnings");
  command->footer(
      "Prints every error and warning on standard error with its place and a hint. Derives nothing.\n"
      "Of a file with several models each is checked. The options count for all models.\n"
      "Exit status 1 when there is an error, with --strict also when there is a warning.\n"
      "Examples:\n"
      "  espalier check tree.l\n"
      "  espalier check models/*.l\n"
      "  espalier check curves.l --list          the models in the file");
  auto options = std::make_shared<ModelCheckOptions>();
  addReadingOptions(*command, options->model, true);
  command->add_option("others", options->others, "Further models")->type_name("MODEL");
  command->add_flag("--list", options->isList, "Only list the models in the file, as FILE:ENTRY");
  command->callback([options, &status] { status = check(*options); });
}

}  // namespace espalier::command
