#include "clients/espalier/resumed_run.h"

#include <memory>
#include <utility>
#include <variant>

#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "engine/language/compiler.h"

namespace espalier::command {
namespace {

// the model given on the command line, or the one that the snapshot carries
std::shared_ptr<const language::Program> resumedProgram(ModelOptions& options, simulation::SnapshotInfo& info,
                                                        FolderSettings& folder, core::FileProvider& files) {
  if (!options.model.empty()) {
    return loadProgram(options, files, &folder);
  }
  language::CompileResult compiled = language::compile(info.compileInput, info.files);
  printDiagnostics(compiled.diagnostics.entries(), true);
  return compiled.program;
}

// the environment given on the command line, or made again as the snapshot says
std::optional<LoadedEnvironment> resumedEnvironment(const ModelOptions& options, const simulation::SnapshotInfo& info,
                                                    core::Compatibility compatibility, core::FileProvider& files) {
  if (!options.environment.empty()) {
    return loadEnvironment(options.environment, compatibility, options.isQuiet, files, options.remote);
  }
  if (info.environmentName.empty()) {
    return LoadedEnvironment{};
  }
  if (info.environmentOrigin.name.empty()) {
    printError("the snapshot was made with the environment '" + info.environmentName +
               "' and does not say how it was set up: give it with --environment");
    return std::nullopt;
  }
  core::MemoryFileProvider carried;
  for (const auto& [name, text] : info.environmentOrigin.files) {
    carried.add(name, text);
  }
  return loadEnvironment(info.environmentOrigin.name, compatibility, options.isQuiet, carried, options.remote);
}

}  // namespace

std::optional<ResumedRun> readResumedRun(const std::string& file, const std::string& option,
                                         core::FileProvider& files) {
  std::optional<std::string> bytes = files.read(file);
  if (!bytes) {
    printError("there is no snapshot '" + file + "'" + (option.empty() ? "" : " (" + option + ")") +
               ": check the name and the working folder");
    return std::nullopt;
  }
  auto read = simulation::readSnapshotInfo(*bytes);
  if (const auto* failure = std::get_if<core::SimulationError>(&read)) {
    printError("'" + file + "': " + failure->message);
    return std::nullopt;
  }
  return ResumedRun{std::move(*bytes), std::move(std::get<simulation::SnapshotInfo>(read))};
}

std::optional<LoadedModel> loadResumed(ModelOptions& options, simulation::SnapshotInfo& info,
                                       core::FileProvider& files) {
  // the run's own seed, not a new one
  if (!options.seed) {
    options.seed = info.seed;
  }
  LoadedModel loaded;
  loaded.program = resumedProgram(options, info, loaded.folder, files);
  if (!loaded.program) {
    return std::nullopt;
  }
  std::optional<LoadedEnvironment> environment =
      resumedEnvironment(options, info, loaded.program->compatibility, files);
  if (!environment) {
    return std::nullopt;
  }
  loaded.environment = std::move(*environment);
  loaded.simulationOptions = simulationOptionsFor(options, *loaded.program);
  loaded.simulationOptions.environmentOrigin = loaded.environment.origin;
  loaded.simulationOptions.palette = loaded.folder.palette.empty() ? info.palette : loaded.folder.palette;
  return loaded;
}

}  // namespace espalier::command
