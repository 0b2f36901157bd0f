#include "clients/espalier/resumed_run.h"

#include <memory>
#include <utility>

#include "clients/espalier/environment_loading.h"
#include "clients/espalier/forest_file.h"
#include "clients/espalier/messages.h"

namespace espalier::command {
namespace {

// the model of the command line, or the model in the snapshot
simulation::Programs resumedPrograms(ModelOptions& options, simulation::SnapshotInfo& info,
                                     server::FolderSettings& folder, core::FileProvider& files) {
  if (const auto forest = forestFileOf(options.model)) {
    std::optional<LoadedModel> loaded = loadForest(*forest, options, files);
    folder = loaded ? std::move(loaded->folder) : server::FolderSettings{};
    return loaded ? std::move(loaded->programs) : simulation::Programs{};
  }
  if (!options.model.empty()) {
    auto program = loadProgram(options, files, &folder);
    return program == nullptr ? simulation::Programs{} : simulation::Programs{std::move(program)};
  }
  auto compiled = simulation::compileModels(info, core::Limits{});
  if (!compiled) {
    printDiagnostics(compiled.error().entries(), true);
    return {};
  }
  return std::move(*compiled);
}

// the environment of the command line, or the environment of the snapshot, made again
std::optional<LoadedEnvironment> resumedEnvironment(const ModelOptions& options, const simulation::SnapshotInfo& info,
                                                    core::Compatibility compatibility, core::FileProvider& files) {
  if (!options.environment.empty()) {
    return loadEnvironment(options.environment, compatibility, options.isQuiet, files, options.environmentOptions());
  }
  if (info.environmentName.empty()) {
    return LoadedEnvironment{};
  }
  if (info.environmentOrigin.name.empty()) {
    printError("the snapshot needs the environment '" + info.environmentName +
               "' but does not hold its configuration: give the environment with --environment");
    return std::nullopt;
  }
  core::MemoryFileProvider carried;
  for (const auto& [name, text] : info.environmentOrigin.files) {
    carried.add(name, text);
  }
  RemoteOptions remote = options.environmentOptions();
  remote.source = EnvironmentSource::Snapshot;
  return loadEnvironment(info.environmentOrigin.name, compatibility, options.isQuiet, carried, remote);
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
  if (!read) {
    printError("'" + file + "': " + read.error().message);
    return std::nullopt;
  }
  return ResumedRun{std::move(*bytes), std::move(*read)};
}

std::optional<LoadedModel> loadResumed(ModelOptions& options, simulation::SnapshotInfo& info,
                                       core::FileProvider& files) {
  if (!options.world.empty() || !options.stepDuration.empty()) {
    printError("--world and --step-duration are for a new run: the snapshot holds the world of its run");
    return std::nullopt;
  }
  // keep the seed of the run
  if (!options.seed) {
    options.seed = info.seed;
  }
  LoadedModel loaded;
  loaded.programs = resumedPrograms(options, info, loaded.folder, files);
  if (loaded.programs.empty()) {
    return std::nullopt;
  }
  loaded.program = loaded.programs.front();
  loaded.plants.resize(info.plantCount);
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
