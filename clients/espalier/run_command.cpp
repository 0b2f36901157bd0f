#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "clients/espalier/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/progress_bar.h"
#include "engine/language/compiler.h"
#include "engine/simulation/snapshot.h"
#include "engine/turtle/export/exporters.h"
#include "server/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOutputKinds = ".svg, .obj or .snapshot";

struct RunOptions {
  ModelOptions model;
  std::vector<std::string> outputs;
  std::string resumed;  // snapshot to go on from; empty: none
};

bool hasKnownSuffix(const std::string& file) {
  const std::string suffix = fs::path(file).extension().string();
  return suffix == ".svg" || suffix == ".obj" || suffix == ".snapshot";
}

// before a long run rather than after it: can the file be written at all
bool isWritable(const std::string& file) {
  const fs::path folder = fs::path(file).parent_path();
  std::error_code error;
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    printError("cannot write '" + file + "': there is no folder '" + folder.string() + "'; make it first");
    return false;
  }
  if (fs::is_directory(file, error)) {
    printError("cannot write '" + file + "': it is a folder; give a file name that ends in " + kOutputKinds);
    return false;
  }
  return true;
}

bool writeOutput(const std::string& file, const std::string& content) {
  if (const auto problem = server::writeFileAtomically(file, content)) {
    printError(*problem);
    return false;
  }
  return true;
}

bool writeResult(const simulation::Simulation& simulation, const std::string& file) {
  const std::string suffix = fs::path(file).extension().string();
  if (suffix == ".snapshot") {
    core::StringSink sink;
    simulation.save(sink);
    return writeOutput(file, sink.take());
  }

  // pictures: the turtle draws the last string
  const auto drawn = simulation.scene();
  if (const auto* failure = std::get_if<core::SimulationError>(&drawn)) {
    printError(formatSimulationError(*failure));
    return false;
  }
  const turtle::Scene& scene = std::get<turtle::Scene>(drawn);
  core::StringSink picture;
  if (suffix == ".svg") {
    turtle::writeSvg(scene, simulation.program().view, turtle::SvgOptions{}, picture);
    return writeOutput(file, picture.take());
  }
  core::StringSink materials;
  const fs::path materialFile = fs::path(file).replace_extension(".mtl");
  turtle::writeObj(scene, simulation.program().view, materialFile.filename().string(), picture, materials);
  return writeOutput(file, picture.take()) && writeOutput(materialFile.string(), materials.take());
}

// compiles the model that a snapshot carries, with the environment it names unless another one is given
std::optional<LoadedModel> loadFromSnapshot(ModelOptions& options, simulation::SnapshotInfo& info,
                                            core::FileProvider& files) {
  language::CompileResult compiled = language::compile(info.compileInput, info.files);
  printDiagnostics(compiled.diagnostics.entries(), true);
  if (!compiled.program) {
    return std::nullopt;
  }
  LoadedModel loaded;
  loaded.program = std::move(compiled.program);
  if (options.environment.empty()) {
    options.environment = info.environmentName;
  }
  if (!options.environment.empty()) {
    loaded.environment =
        loadEnvironment(options.environment, loaded.program->compatibility, options.isQuiet, files);
    if (!loaded.environment) {
      return std::nullopt;
    }
  }
  loaded.simulationOptions = simulationOptionsFor(options, *loaded.program);
  return loaded;
}

// goes on to the last step; the bar is shown on a terminal only
std::optional<core::SimulationError> runToEnd(simulation::Simulation& simulation, bool hasProgress) {
  ProgressBar bar(hasProgress);
  while (!simulation.isFinished()) {
    if (auto failure = simulation.step()) {
      return failure;
    }
    bar.show(simulation.completedSteps(), simulation.derivationLength(), simulation.statistics().modules);
  }
  return std::nullopt;
}

int run(RunOptions& options) {
  for (const std::string& file : options.outputs) {
    if (!isWritable(file)) {
      return kFailure;
    }
  }
  server::DiskFileProvider files;
  std::optional<std::string> snapshot;
  std::optional<simulation::SnapshotInfo> info;
  if (!options.resumed.empty()) {
    snapshot = files.read(options.resumed);
    if (!snapshot) {
      printError("there is no snapshot '" + options.resumed + "' (--resume): check the name and the working folder");
      return kFailure;
    }
    auto read = simulation::readSnapshotInfo(*snapshot);
    if (const auto* failure = std::get_if<core::SimulationError>(&read)) {
      printError("'" + options.resumed + "': " + formatSimulationError(*failure));
      return kFailure;
    }
    info = std::move(std::get<simulation::SnapshotInfo>(read));
    if (!options.model.seed && info->hasSeed) {
      options.model.seed = info->seed;
    }
  }

  std::optional<LoadedModel> loaded =
      options.model.model.empty() ? loadFromSnapshot(options.model, *info, files) : loadModel(options.model, files);
  if (!loaded) {
    return kFailure;
  }
  const std::size_t plantCount = info ? info->plantCount : 1;
  simulation::Simulation simulation(loaded->program, std::vector<turtle::PlantPlacement>(plantCount),
                                    std::move(loaded->environment), std::move(loaded->simulationOptions));
  std::optional<core::SimulationError> failure = snapshot ? simulation.restore(*snapshot) : simulation.rewind();
  if (!failure) {
    failure = runToEnd(simulation, !options.model.isQuiet);
  }
  if (failure) {
    printError(formatSimulationError(*failure));
    return kFailure;
  }
  for (const std::string& file : options.outputs) {
    if (!writeResult(simulation, file)) {
      return kFailure;
    }
    if (!options.model.isQuiet) {
      printNote("wrote " + file + " (step " + std::to_string(simulation.completedSteps()) + ", " +
                std::to_string(simulation.statistics().modules) + " modules)");
    }
  }
  return kSuccess;
}

}  // namespace

void addRun(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("run", "Grow a model and write its picture, geometry or snapshot");
  command->footer(
      "The suffix of the output file decides what is written: .svg a picture, .obj (and .mtl) geometry, .snapshot the "
      "complete state.\n"
      "Examples:\n"
      "  espalier run tree.l -o tree.svg\n"
      "  espalier run tiers.l --environment honda.json --steps 5 -o tiers.snapshot\n"
      "  espalier run --resume tiers.snapshot --environment honda.json --steps 12 -o tiers.svg");
  auto options = std::make_shared<RunOptions>();
  addReadingOptions(*command, options->model, false);
  addRunningOptions(*command, options->model);
  command->add_option("-o,--output", options->outputs, "File to write; may be repeated")
      ->type_name("FILE")
      ->required()
      ->allow_extra_args(false)
      ->check([](const std::string& file) {
        return hasKnownSuffix(file) ? std::string{}
                                    : "'" + file + "' has no known suffix: give a name that ends in " + kOutputKinds;
      });
  command
      ->add_option("--resume", options->resumed,
                   "Go on from a snapshot; it carries its model, so MODEL may be left out")
      ->type_name("FILE.snapshot");
  command->callback([options, &status] {
    if (options->model.model.empty() && options->resumed.empty()) {
      throw CLI::RequiredError("MODEL (or --resume FILE.snapshot)");
    }
    status = run(*options);
  });
}

}  // namespace espalier::command
