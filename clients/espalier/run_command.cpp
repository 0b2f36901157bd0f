#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "clients/espalier/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/progress_bar.h"
#include "clients/espalier/time_limit.h"
#include "clients/espalier/trace_option.h"
#include "engine/language/compiler.h"
#include "engine/simulation/snapshot.h"
#include "engine/turtle/export/exporters.h"
#include "server/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSnapshotSuffix = ".snapshot";

struct RunOptions {
  ModelOptions model;
  TraceOption trace;
  std::vector<std::string> outputs;
  std::string resumed;  // snapshot to go on from; empty: none
};

// the suffixes of all outputs, for messages: `.svg, .obj or .snapshot`
std::string outputKinds() {
  std::string kinds;
  for (const turtle::ExportFormat& format : turtle::exportFormats()) {
    kinds += (kinds.empty() ? "" : ", ") + std::string(format.suffix);
  }
  return kinds + " or " + kSnapshotSuffix;
}

bool hasKnownSuffix(const std::string& file) {
  return fs::path(file).extension() == kSnapshotSuffix || turtle::findExportFormatOfFile(file) != nullptr;
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
    printError("cannot write '" + file + "': it is a folder; give a file name that ends in " + outputKinds());
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

bool writeResult(const simulation::Simulation& simulation, const language::Palette& palette, const std::string& file) {
  if (fs::path(file).extension() == kSnapshotSuffix) {
    core::StringSink sink;
    simulation.save(sink);
    return writeOutput(file, sink.take());
  }

  // pictures and geometry: the turtle draws the last string
  const auto drawn = simulation.scene();
  if (const auto* failure = std::get_if<core::SimulationError>(&drawn)) {
    printError(formatSimulationError(*failure));
    return false;
  }
  core::StringSink content;
  std::map<std::string, core::StringSink> companions;
  const turtle::ExportTarget target{
      .fileName = fs::path(file).filename().string(),
      .sink = content,
      .openCompanion = [&companions](const std::string& name) -> core::ByteSink& { return companions[name]; },
      .progress = {}};
  const turtle::ExportInput input{
      .scene = std::get<turtle::Scene>(drawn), .view = simulation.program().view, .palette = &palette};
  if (const auto problem = turtle::findExportFormatOfFile(file)->write(input, target)) {
    printError("cannot write '" + file + "': " + *problem);
    return false;
  }
  return writeOutput(file, content.take()) && std::ranges::all_of(companions, [&file](auto& companion) {
           return writeOutput(fs::path(file).replace_filename(companion.first).string(), companion.second.take());
         });
}

// a snapshot file and what it says about itself
struct ResumedRun {
  std::string bytes;
  simulation::SnapshotInfo info;
};

std::optional<ResumedRun> readResumedRun(const std::string& file, core::FileProvider& files) {
  std::optional<std::string> bytes = files.read(file);
  if (!bytes) {
    printError("there is no snapshot '" + file + "' (--resume): check the name and the working folder");
    return std::nullopt;
  }
  auto read = simulation::readSnapshotInfo(*bytes);
  if (const auto* failure = std::get_if<core::SimulationError>(&read)) {
    printError("'" + file + "': " + failure->message);
    return std::nullopt;
  }
  return ResumedRun{std::move(*bytes), std::move(std::get<simulation::SnapshotInfo>(read))};
}

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
    return loadEnvironment(options.environment, compatibility, options.isQuiet, files);
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
  return loadEnvironment(info.environmentOrigin.name, compatibility, options.isQuiet, carried);
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
  return loaded;
}

// goes on to the last step, of the model or `last`; the bar is shown on a terminal only
std::optional<core::SimulationError> runToEnd(simulation::Simulation& simulation, std::optional<std::uint64_t> last,
                                              bool hasProgress, TraceOption& trace) {
  ProgressBar bar(hasProgress);
  trace.begin(simulation);
  while (!isOver(simulation, last)) {
    if (auto failure = simulation.step()) {
      return failure;
    }
    trace.complete(simulation);
    bar.show(simulation.completedSteps(), last.value_or(simulation.derivationLength()),
             simulation.statistics().modules);
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
  std::optional<ResumedRun> resumed;
  if (!options.resumed.empty()) {
    resumed = readResumedRun(options.resumed, files);
    if (!resumed) {
      return kFailure;
    }
  }
  std::optional<LoadedModel> loaded =
      resumed ? loadResumed(options.model, resumed->info, files) : loadModel(options.model, files);
  if (!loaded || !options.trace.open(loaded->environment)) {
    return kFailure;
  }

  simulation::Simulation simulation(loaded->program,
                                    std::vector<turtle::PlantPlacement>(resumed ? resumed->info.plantCount : 1),
                                    std::move(loaded->environment.process), std::move(loaded->simulationOptions));
  const TimeLimit time(simulation, options.model.seconds());
  std::optional<core::SimulationError> failure = resumed ? simulation.restore(resumed->bytes) : simulation.rewind();
  if (!failure) {
    failure = runToEnd(simulation, lastStepOf(loaded->folder, options.model.steps, simulation), !options.model.isQuiet,
                       options.trace);
  }
  if (!options.trace.close() && !failure) {
    return kFailure;
  }
  if (failure) {
    printError(formatSimulationError(time.explained(*failure)));
    return kFailure;
  }
  for (const std::string& file : options.outputs) {
    if (!writeResult(simulation, loaded->folder.palette, file)) {
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
      "The suffix of the output file decides what is written: .svg a picture, .obj (and .mtl) geometry, .snapshot the\n"
      "complete state.\n"
      "A model folder brings its colours, its environment and, with -a, its last step.\n"
      "Examples:\n"
      "  espalier run lilac -o lilac.svg\n"
      "  espalier run tree.l -o tree.svg\n"
      "  espalier run tiers.l --environment honda.json --steps 5 -o tiers.snapshot\n"
      "  espalier run --resume tiers.snapshot --steps 12 -o tiers.svg");
  auto options = std::make_shared<RunOptions>();
  addReadingOptions(*command, options->model, false);
  addRunningOptions(*command, options->model);
  options->trace.addTo(*command);
  command->add_option("-o,--output", options->outputs, "File to write; may be repeated")
      ->type_name("FILE")
      ->required()
      ->allow_extra_args(false)
      ->check([](const std::string& file) {
        return hasKnownSuffix(file) ? std::string{}
                                    : "'" + file + "' has no known suffix: give a name that ends in " + outputKinds();
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
