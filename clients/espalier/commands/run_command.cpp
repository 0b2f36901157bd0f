#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/field_outputs.h"
#include "clients/espalier/output/growth_outputs.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/output/plant_rows.h"
#include "clients/espalier/output/progress_bar.h"
#include "clients/espalier/resumed_run.h"
#include "clients/espalier/time_limit.h"
#include "clients/espalier/trace_option.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct RunOptions {
  ModelOptions model;
  TraceOption trace;
  OutputOptions outputs;
  FieldOutputs fields;
  std::string resumed;         // snapshot to go on from; empty: none
  std::uint64_t variants = 0;  // plants from as many seeds; 0: one plant of the run's seed
  bool writesEveryStep = false;
  std::optional<bool> hasSharedFrame;  // all frames have one scale; nothing: unless that would disturb an environment
  std::optional<double> rowSpacing;    // variants stand in one file, so far apart; 0: so that they do not touch
};

/// Takes what a model writes into files, and forgets it.
class ForgetfulWriter final : public core::FileWriter {
 public:
  [[nodiscard]] std::optional<std::string> write(const std::string&, bool, std::string_view) override {
    return std::nullopt;
  }
};

bool isPictureFile(const OutputOptions& outputs, const std::string& file) {
  const turtle::ExportFormat* const format = formatOf(outputs, file);
  return format != nullptr &&
         (format->name == "png" || format->name == "svg" || format->name == "eps" || format->name == "ps");
}

bool isOtherProcess(const std::string& environment) {
  return environment.starts_with("tcp://") || environment.starts_with("stdio:");
}

// whether the frames of a run are fitted together; says why not when that is not what was asked for
bool sharesFrame(const RunOptions& options, const ModelOptions& model) {
  const auto isPicture = [&](const std::string& file) { return isPictureFile(options.outputs, file); };
  if (!options.writesEveryStep || options.outputs.picture.framing != turtle::PictureFraming::Fitted ||
      std::ranges::none_of(options.outputs.files, isPicture)) {
    return false;
  }
  if (!options.hasSharedFrame && isOtherProcess(model.environment)) {
    if (!model.isQuiet) {
      printNote(
          "each picture is fitted on its own: for one scale the run is made twice, and its environment is another "
          "process. --frames shared does that");
    }
    return false;
  }
  return options.hasSharedFrame.value_or(true);
}

// what a run from a snapshot does when it derives nothing
void explainNothingToDo(const simulation::Simulation& simulation, std::optional<std::uint64_t> last) {
  const std::uint64_t step = simulation.completedSteps();
  std::string sentence = "the snapshot is at step " + std::to_string(step);
  if (last && *last < step) {
    sentence += ", beyond step " + std::to_string(*last) + ": nothing is derived and step " + std::to_string(step) +
                " is written";
  } else {
    sentence += ", the last one: nothing is derived. --steps N goes on to step N";
  }
  printNote(sentence);
}

// goes on to the last step, of the model or `last`; the bar is shown on a terminal only
bool runToEnd(simulation::Simulation& simulation, std::optional<std::uint64_t> last, RunOptions& options,
              const OutputWriter& writer, const TimeLimit& time) {
  ProgressBar bar(!options.model.isQuiet);
  options.trace.begin(simulation);
  std::optional<GrowthOutputs> growth;
  const auto writeStep = [&] {
    const std::uint64_t step = simulation.completedSteps();
    return options.fields.addStep(simulation, options.writesEveryStep ? std::optional(step) : std::nullopt,
                                  options.model.isQuiet) &&
           (!options.writesEveryStep || (writer.write(simulation, step) && growth->addFrame(simulation)));
  };
  if (options.writesEveryStep) {
    growth.emplace(options.outputs, simulation.completedSteps(), last.value_or(simulation.derivationLength()));
  }
  if (!writeStep()) {
    return false;
  }
  while (!isOver(simulation, last)) {
    if (const auto failure = simulation.step()) {
      bar.clear();
      printError(formatSimulationError(time.explained(*failure)));
      return false;
    }
    if (options.writesEveryStep) {
      bar.clear();
    }
    if (!writeStep()) {
      return false;
    }
    options.trace.complete(simulation);
    bar.show(simulation.completedSteps(), last.value_or(simulation.derivationLength()),
             simulation.statistics().modules);
  }
  return !growth || growth->finish(options.model.isQuiet);
}

// the simulation of a loaded model, at no step yet
std::unique_ptr<simulation::Simulation> begin(LoadedModel& loaded) {
  return std::make_unique<simulation::Simulation>(loaded.programs, loaded.plants, std::move(loaded.environment.process),
                                                  std::move(loaded.simulationOptions));
}

// what all frames of a run show together: the run is made once before it is drawn, with the same seed and without files
std::optional<turtle::PictureFrame> frameOfAll(const RunOptions& options, ModelOptions model,
                                               std::optional<std::uint64_t> seed) {
  server::DiskFileProvider files;
  std::optional<ResumedRun> resumed;
  if (!options.resumed.empty() && !(resumed = readResumedRun(options.resumed, "--resume", files))) {
    return std::nullopt;
  }
  model.isQuiet = true;
  model.seed = seed;
  std::optional<LoadedModel> loaded = resumed ? loadResumed(model, resumed->info, files) : loadModel(model, files);
  if (!loaded) {
    return std::nullopt;
  }
  loaded->simulationOptions.messages = {};
  loaded->simulationOptions.fileWriter = std::make_shared<ForgetfulWriter>();
  const FolderSettings folder = loaded->folder;
  const std::unique_ptr<simulation::Simulation> simulation = begin(*loaded);
  std::optional<core::SimulationError> failure = resumed ? simulation->restore(resumed->bytes) : simulation->rewind();
  const std::optional<std::uint64_t> last = failure ? std::nullopt : lastStepOf(folder, model.steps, *simulation);
  ProgressBar bar(!options.model.isQuiet);
  turtle::PictureFrame frame;
  while (!failure) {
    const auto scene = simulation->scene();
    if (const auto* problem = std::get_if<core::SimulationError>(&scene)) {
      failure = *problem;
      break;
    }
    const turtle::ExportInput input{.scene = std::get<turtle::Scene>(scene), .view = simulation->view()};
    const turtle::ScenePlacement here;
    frame.include(turtle::pictureFrame({{&input, 1}, {&here, 1}}, options.outputs.picture));
    if (isOver(*simulation, last)) {
      break;
    }
    failure = simulation->step();
    bar.show(simulation->completedSteps(), last.value_or(simulation->derivationLength()),
             simulation->statistics().modules);
  }
  // the run itself meets a failure again, behind the frames that it can draw
  return frame;
}

// what a run leaves that failed behind its first step: the snapshots among its files, of the last complete step
void writeRest(const simulation::Simulation& simulation, const OutputOptions& outputs,
               std::optional<std::uint64_t> variant, bool isQuiet) {
  if (simulation.completedSteps() == 0) {
    return;
  }
  OutputOptions rest = outputs;
  std::erase_if(rest.files, [&](const std::string& file) { return formatOf(outputs, file) != nullptr; });
  if (rest.files.empty()) {
    if (!isQuiet) {
      printNote("with -o FILE.snapshot a run that fails leaves its last complete step, to go on from with --resume");
    }
    return;
  }
  if (OutputWriter(rest, isQuiet).write(simulation, variant, 3) && !isQuiet) {
    printNote("that is step " + std::to_string(simulation.completedSteps()) + ": go on from it with --resume");
  }
}

// one run, written with a number when it is one of several variants
int runOnce(RunOptions& options, ModelOptions model, std::optional<std::uint64_t> variant, PlantRows* rows = nullptr) {
  server::DiskFileProvider files;
  std::optional<ResumedRun> resumed;
  if (!options.resumed.empty()) {
    resumed = readResumedRun(options.resumed, "--resume", files);
    if (!resumed) {
      return kFailure;
    }
  }
  std::optional<LoadedModel> loaded = resumed ? loadResumed(model, resumed->info, files) : loadModel(model, files);
  if (!loaded || !options.trace.open(loaded->environment)) {
    return kFailure;
  }
  if (variant == 1 &&
      std::none_of(loaded->programs.begin(), loaded->programs.end(),
                   [](const auto& program) { return drawsRandomNumbers(*program); }) &&
      !model.isQuiet) {
    printNote("the model draws no random numbers: all variants are equal");
  }
  // with --every a format that can hold all steps has one file, which OutputWriter does not see
  OutputOptions separate = options.outputs;
  if (options.writesEveryStep) {
    std::erase_if(separate.files, [&](const std::string& file) { return isGrowthFile(options.outputs, file); });
  }
  if (sharesFrame(options, model)) {
    const simulation::SimulationOptions& made = loaded->simulationOptions;
    separate.picture.frame = frameOfAll(options, model, made.hasSeed ? std::optional(made.seed) : std::nullopt);
    if (!separate.picture.frame) {
      return kFailure;
    }
  }
  options.fields.begin(variant);
  const std::unique_ptr<simulation::Simulation> begun = begin(*loaded);
  simulation::Simulation& simulation = *begun;
  const TimeLimit time(simulation, model.seconds());
  if (const auto failure = resumed ? simulation.restore(resumed->bytes) : simulation.rewind()) {
    printError(formatSimulationError(time.explained(*failure)));
    return kFailure;
  }
  const std::optional<std::uint64_t> last = lastStepOf(loaded->folder, model.steps, simulation);
  if (resumed && isOver(simulation, last) && !model.isQuiet) {
    explainNothingToDo(simulation, last);
  }
  const OutputWriter writer(separate, model.isQuiet);
  const bool isComplete = runToEnd(simulation, last, options, writer, time);
  if (!isComplete && !options.writesEveryStep && rows == nullptr) {
    writeRest(simulation, options.outputs, variant, model.isQuiet);
  }
  if (!options.trace.close() || !isComplete) {
    return kFailure;
  }
  if (!options.fields.finish(simulation, options.writesEveryStep, options.model.isQuiet)) {
    return kFailure;
  }
  if (rows != nullptr) {
    return rows->add(simulation) ? kSuccess : kFailure;
  }
  return options.writesEveryStep || writer.write(simulation, variant, 3) ? kSuccess : kFailure;
}

int run(RunOptions& options) {
  const bool isInRows = options.rowSpacing.has_value();
  if (const int status = isInRows ? checkPlacedOutputs(options.outputs) : checkOutputs(options.outputs);
      status != kSuccess) {
    return status;
  }
  if (!options.fields.parse()) {
    return kUsage;
  }
  if (options.variants == 0) {
    return runOnce(options, options.model, std::nullopt);
  }
  const std::uint64_t firstSeed = options.model.seed.value_or(1);
  PlantRows rows;
  for (std::uint64_t variant = 1; variant <= options.variants; ++variant) {
    ModelOptions model = options.model;
    model.seed = firstSeed + (variant - 1);
    if (const int status = runOnce(options, std::move(model), variant, isInRows ? &rows : nullptr);
        status != kSuccess) {
      return status;
    }
  }
  return !isInRows || rows.write(options.outputs, *options.rowSpacing, options.model.isQuiet) ? kSuccess : kFailure;
}

}  // namespace

void addRun(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("run", "Grow a model and write pictures, meshes, tables or a snapshot");
  command->footer(
      "The suffix of each output file decides what is written; --format's help lists all formats.\n"
      "A model folder brings its colours, its environment and, with -a, its last step.\n"
      "Examples:\n"
      "  espalier run lilac -o lilac.png --size 1920x1080\n"
      "  espalier run tree.l -o tree.glb -o tree.png -o tree.mtg\n"
      "  espalier run tree.l --every -o frame.png            frame-0000.png, frame-0001.png, ...\n"
      "  espalier run forest.json -o stand.png               several plants, of several models, in one environment\n"
      "  espalier run bush.l --variants 20 -o bush-%02d.glb --detail 0.5\n"
      "  espalier run bush.l --variants 20 --in-rows 0 -o nursery.glb -o nursery.png\n"
      "  espalier run tiers.l --environment honda.json --steps 5 -o tiers.snapshot\n"
      "  espalier run --resume tiers.snapshot --steps 12 -o tiers.svg\n"
      "  espalier run roots.l -o roots.png --field water.vti --field waterContent@z=water.png --field water.csv");
  auto options = std::make_shared<RunOptions>();
  addReadingOptions(*command, options->model, false);
  addRunningOptions(*command, options->model);
  options->trace.addTo(*command);
  addOutputOptions(*command, options->outputs, true);
  options->fields.addTo(*command);
  CLI::Option* resume = command->add_option("--resume", options->resumed,
                                            "Go on from a snapshot; it carries its model, so MODEL may be left out");
  resume->type_name("FILE.snapshot");
  CLI::Option* every = command->add_flag(
      "--every", options->writesEveryStep,
      "Write every step, from 0: the step's number goes where the file name has %d or %04d, or before its suffix;\n"
      "a .usda without %d holds the whole growth animation");
  command
      ->add_option_function<std::string>(
          "--frames", [options](const std::string& name) { options->hasSharedFrame = name == "shared"; },
          "With --every, what fitted pictures show: shared (all frames in one scale, so that nothing jumps; the run "
          "is\n"
          "made twice) or own (each as large as the page allows). shared, unless the environment is another process")
      ->check(CLI::IsMember({"shared", "own"}))
      ->needs(every);
  CLI::Option* variants =
      addWholeNumber(*command, "--variants",
                     "Grow so many plants, from the seeds S, S+1, ... of --seed S (1); files are numbered from 001", 1,
                     1'000'000, [options](std::uint64_t count) { options->variants = count; })
          ->type_name("N")
          ->excludes(every)
          ->excludes(resume);
  command
      ->add_option(
          "--in-rows", options->rowSpacing,
          "All variants in one file, in rows so far apart, 0: so that they do not touch; equal ones share their\n"
          "meshes in a .glb")
      ->type_name("DISTANCE")
      ->check(CLI::NonNegativeNumber)
      ->needs(variants);
  command->callback([options, &status] {
    if (options->model.model.empty() && options->resumed.empty()) {
      throw CLI::RequiredError("MODEL (or --resume FILE.snapshot)");
    }
    options->outputs.picture.threads = options->model.threadCount();
    status = run(*options);
  });
}

}  // namespace espalier::command
