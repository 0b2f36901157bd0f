#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/contact_sheet.h"
#include "clients/espalier/output/field_outputs.h"
#include "clients/espalier/output/growth_outputs.h"
#include "clients/espalier/output/movies.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/output/paraview_series.h"
#include "clients/espalier/output/plant_rows.h"
#include "clients/espalier/output/progress_bar.h"
#include "clients/espalier/resumed_run.h"
#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/time_limit.h"
#include "clients/espalier/trace_option.h"
#include "engine/language/dialects/dialect.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

struct RunOptions {
  ModelOptions model;
  TraceOption trace;
  OutputOptions outputs;
  FieldOutputs fields;
  std::string resumed;         // snapshot to continue from; empty: none
  std::uint64_t variants = 0;  // plants, each with its own seed; 0: one plant with the seed of the run
  bool writesEveryStep = false;
  std::vector<std::string> movies;  // files of all steps, or of a turn
  unsigned framesPerSecond = 12;
  bool runsAll = false;                // the models of a file, into one contact sheet
  std::optional<bool> hasSharedFrame;  // all frames have one scale; nothing: unless the environment is a process
  std::optional<double> rowSpacing;    // distance of the variants in one file; 0: so that they do not touch
};

/// Discards the files of the model.
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

// whether all frames of a run have one scale; prints a note when the environment prevents it
bool sharesFrame(const RunOptions& options, const ModelOptions& model) {
  const auto isPicture = [&](const std::string& file) { return isPictureFile(options.outputs, file); };
  if (!options.writesEveryStep || options.outputs.picture.framing != turtle::PictureFraming::Fitted ||
      (options.movies.empty() && std::ranges::none_of(options.outputs.files, isPicture))) {
    return false;
  }
  if (!options.hasSharedFrame && isOtherProcess(model.environment)) {
    if (!model.isQuiet) {
      printNote(
          "each picture has its own scale: one scale needs a second run, and the environment is another process. "
          "--frames shared makes the second run");
    }
    return false;
  }
  return options.hasSharedFrame.value_or(true);
}

// says why a run from a snapshot derives nothing
void explainNothingToDo(const simulation::Simulation& simulation, std::optional<std::uint64_t> last) {
  const std::uint64_t step = simulation.completedSteps();
  std::string sentence = "the snapshot is at step " + std::to_string(step);
  if (last && *last < step) {
    sentence += ", beyond step " + std::to_string(*last) + ": no step is derived, and step " + std::to_string(step) +
                " is written";
  } else {
    sentence += ", the last one: no step is derived. --steps N continues to step N";
  }
  printNote(sentence);
}

// the files of VTK with what modules know
std::vector<std::string> meshesOfVtk(const RunOptions& options) {
  std::vector<std::string> files;
  std::ranges::copy_if(options.outputs.files, std::back_inserter(files), [&](const std::string& file) {
    const turtle::ExportFormat* const format = formatOf(options.outputs, file);
    return format != nullptr && (format->suffix == ".vtp" || format->suffix == ".vtu");
  });
  return files;
}

// the files that may become a series for ParaView
std::vector<std::string> seriesFiles(const RunOptions& options) {
  std::vector<std::string> files = meshesOfVtk(options);
  std::ranges::copy(options.fields.files(), std::back_inserter(files));
  return files;
}

// makes all steps up to `last` or the end of the model; the bar appears on a terminal only
bool runToEnd(simulation::Simulation& simulation, std::optional<std::uint64_t> last, RunOptions& options,
              const OutputWriter& writer, const TimeLimit& time) {
  ProgressBar bar(!options.model.isQuiet);
  options.trace.begin(simulation);
  std::optional<GrowthOutputs> growth;
  std::vector<std::uint64_t> steps;
  Movies movies;
  if (options.writesEveryStep && !movies.begin(options.movies, options.framesPerSecond)) {
    return false;
  }
  const auto writeStep = [&] {
    const std::uint64_t step = simulation.completedSteps();
    steps.push_back(step);
    return options.fields.addStep(simulation, options.writesEveryStep ? std::optional(step) : std::nullopt,
                                  options.model.isQuiet) &&
           (!options.writesEveryStep ||
            (writer.write(simulation, step) && growth->addFrame(simulation) && movies.add(simulation, writer)));
  };
  if (options.writesEveryStep) {
    growth.emplace(options.outputs, simulation.completedSteps(), last.value_or(simulation.derivationLength()));
  }
  if (!writeStep()) {
    return false;
  }
  while (!server::isOver(simulation, last)) {
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
  if (options.writesEveryStep && !writeParaviewSeries(seriesFiles(options), steps, options.model.isQuiet)) {
    return false;
  }
  return !growth || (growth->finish(options.model.isQuiet) && movies.finish(options.model.isQuiet));
}

// the pictures of one turn of the plant, all in one scale
bool writeTurn(const simulation::Simulation& simulation, const RunOptions& options, OutputOptions outputs) {
  const auto drawn = simulation.scene();
  if (!drawn) {
    printError(formatSimulationError(drawn.error()));
    return false;
  }
  const auto turnOf = [&](std::uint64_t frame) {
    return 360.0 * static_cast<double>(frame) / static_cast<double>(outputs.turntable);
  };
  turtle::PictureFrame all;
  for (std::uint64_t frame = 0; frame < outputs.turntable; ++frame) {
    outputs.render.turn = turnOf(frame);
    const files::ViewSettings view = viewToRender(simulation.view(), outputs.render);
    const turtle::ExportInput input{.scene = *drawn, .view = view};
    const turtle::ScenePlacement here;
    all.include(turtle::pictureFrame({{&input, 1}, {&here, 1}}, outputs.picture));
  }
  outputs.picture.frame = all;
  const OutputWriter writer(outputs, options.model.isQuiet);
  Movies movies;
  if (!movies.begin(options.movies, options.framesPerSecond)) {
    return false;
  }
  for (std::uint64_t frame = 0; frame < outputs.turntable; ++frame) {
    outputs.render.turn = turnOf(frame);
    if (!writer.write(simulation, frame) || !movies.add(simulation, writer)) {
      return false;
    }
  }
  return movies.finish(options.model.isQuiet);
}

// the simulation of a loaded model, at no step yet
std::unique_ptr<simulation::Simulation> begin(LoadedModel& loaded) {
  return std::make_unique<simulation::Simulation>(loaded.programs, loaded.plants, std::move(loaded.environment.process),
                                                  std::move(loaded.simulationOptions));
}

// the part of space that all frames show: from a first run with the same seed that writes no files
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
  const server::FolderSettings folder = loaded->folder;
  const std::unique_ptr<simulation::Simulation> simulation = begin(*loaded);
  std::optional<core::SimulationError> failure = resumed ? simulation->restore(resumed->bytes) : simulation->rewind();
  const std::optional<std::uint64_t> last =
      failure ? std::nullopt : server::lastStepOf(folder, model.steps, *simulation);
  ProgressBar bar(!options.model.isQuiet);
  turtle::PictureFrame frame;
  while (!failure) {
    const auto scene = simulation->scene();
    if (!scene) {
      failure = scene.error();
      break;
    }
    const files::ViewSettings view =
        options.outputs.render.isOn ? viewToRender(simulation->view(), options.outputs.render) : simulation->view();
    const turtle::ExportInput input{.scene = *scene, .view = view};
    const turtle::ScenePlacement here;
    frame.include(turtle::pictureFrame({{&input, 1}, {&here, 1}}, options.outputs.picture));
    if (server::isOver(*simulation, last)) {
      break;
    }
    failure = simulation->step();
    bar.show(simulation->completedSteps(), last.value_or(simulation->derivationLength()),
             simulation->statistics().modules);
  }
  // the run itself reports the failure again, after its last complete frame
  return frame;
}

// after a run that failed behind its first step: writes the snapshots among its files, of the last complete step
void writeRest(const simulation::Simulation& simulation, const OutputOptions& outputs,
               std::optional<std::uint64_t> variant, bool isQuiet) {
  if (simulation.completedSteps() == 0) {
    return;
  }
  OutputOptions rest = outputs;
  std::erase_if(rest.files, [&](const std::string& file) { return formatOf(outputs, file) != nullptr; });
  if (rest.files.empty()) {
    if (!isQuiet) {
      printNote("with -o FILE.snapshot a failed run saves its last complete step, and --resume continues from it");
    }
    return;
  }
  if (OutputWriter(rest, isQuiet).write(simulation, variant, 3) && !isQuiet) {
    printNote("the snapshot holds step " + std::to_string(simulation.completedSteps()) +
              ": continue from it with --resume");
  }
}

// one run; the files of a variant have its number
int runOnce(RunOptions& options, ModelOptions model, std::optional<std::uint64_t> variant, PlantRows* rows = nullptr,
            ContactSheet* sheet = nullptr) {
  server::DiskFileProvider files;
  std::optional<ResumedRun> resumed;
  if (!options.resumed.empty()) {
    resumed = readResumedRun(options.resumed, "--resume", files);
    if (!resumed) {
      return kFailure;
    }
  }
  model.remote.keepsState =
      std::any_of(options.outputs.files.begin(), options.outputs.files.end(),
                  [&](const std::string& file) { return formatOf(options.outputs, file) == nullptr; });
  // messages about the model came with the first variant; each run has messages of its own
  model.isQuiet = options.model.isQuiet || variant > 1;
  std::optional<LoadedModel> loaded = resumed ? loadResumed(model, resumed->info, files) : loadModel(model, files);
  if (!loaded) {
    return kFailure;
  }
  model.isQuiet = options.model.isQuiet;
  loaded->simulationOptions.messages = standardErrorMessages(model.isQuiet);
  if (loaded->environment.onFailure != nullptr) {
    *loaded->environment.onFailure = failureNotes(model.isQuiet);
  }
  if (!options.trace.open(loaded->environment)) {
    return kFailure;
  }
  options.outputs.lengthUnit = model.lengthUnit;
  options.outputs.rootLabels = model.rootLabels;
  if (variant == 1 &&
      std::none_of(loaded->programs.begin(), loaded->programs.end(),
                   [](const auto& program) { return drawsRandomNumbers(*program); }) &&
      !model.isQuiet) {
    printNote("the model draws no random numbers, so all variants are equal");
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
  simulation.followAges(!meshesOfVtk(options).empty());
  if (const auto failure = resumed ? simulation.restore(resumed->bytes) : simulation.rewind()) {
    printError(formatSimulationError(time.explained(*failure)));
    return kFailure;
  }
  const std::optional<std::uint64_t> last = server::lastStepOf(loaded->folder, model.steps, simulation);
  if (resumed && server::isOver(simulation, last) && !model.isQuiet) {
    explainNothingToDo(simulation, last);
  }
  const OutputWriter writer(separate, model.isQuiet);
  const bool isComplete = runToEnd(simulation, last, options, writer, time);
  if (!isComplete && !options.writesEveryStep && rows == nullptr && sheet == nullptr) {
    writeRest(simulation, options.outputs, variant, model.isQuiet);
  }
  if (!options.trace.close() || !isComplete) {
    return kFailure;
  }
  if (!options.fields.finish(simulation, options.writesEveryStep, options.model.isQuiet)) {
    return kFailure;
  }
  if (sheet != nullptr) {
    return sheet->add(simulation, language::splitEntry(model.model, files).entry) ? kSuccess : kFailure;
  }
  if (rows != nullptr) {
    return rows->add(simulation) ? kSuccess : kFailure;
  }
  if (separate.turntable > 0) {
    return writeTurn(simulation, options, separate) ? kSuccess : kFailure;
  }
  return options.writesEveryStep || writer.write(simulation, variant, 3) ? kSuccess : kFailure;
}

// every model of a file in one picture; a model that fails leaves its cell empty
int runAll(RunOptions& options) {
  if (const int status = checkSheetOutputs(options.outputs); status != kSuccess) {
    return status;
  }
  server::DiskFileProvider files;
  const std::vector<std::string> entries = modelEntries(options.model, files);
  if (entries.empty()) {
    printError("'" + options.model.model + "' does not hold several models: leave out --all");
    return kFailure;
  }
  setCellSize(options.outputs);
  ContactSheet sheet(options.outputs);
  int status = kSuccess;
  for (const std::string& entry : entries) {
    ModelOptions model = options.model;
    model.model += ":" + entry;
    if (runOnce(options, model, std::nullopt, nullptr, &sheet) != kSuccess) {
      printNote("the model '" + entry + "' failed: its cell of the sheet is empty");
      sheet.addFailed(entry);
      status = kFailure;
    }
  }
  return sheet.write(options.model.isQuiet) ? status : kFailure;
}

// takes movies out of the files: they are made picture by picture
int takeMovies(RunOptions& options) {
  std::vector<std::string>& files = options.outputs.files;
  const auto first = std::stable_partition(files.begin(), files.end(), [&](const std::string& file) {
    return !options.outputs.format.empty() || !isMovieFile(file);
  });
  options.movies.assign(first, files.end());
  files.erase(first, files.end());
  if (!options.movies.empty() && !options.writesEveryStep && options.outputs.turntable == 0) {
    printError("'" + options.movies.front() +
               "' is a movie: give --every for the growth of the plant, or --turntable N for one turn in N pictures");
    return kUsage;
  }
  for (const std::string& movie : options.movies) {
    const fs::path folder = fs::path(movie).parent_path();
    std::error_code error;
    if ((!folder.empty() && !fs::is_directory(folder, error)) || fs::is_directory(movie, error)) {
      printError("cannot write '" + movie + "': there is no folder for it, or it is a folder; give another name");
      return kFailure;
    }
  }
  return kSuccess;
}

// files that the options do not fit
int checkFiles(const RunOptions& options) {
  const OutputOptions& outputs = options.outputs;
  const auto isPng = [&](const std::string& file) {
    const turtle::ExportFormat* const format = formatOf(outputs, file);
    return format != nullptr && format->name == "png";
  };
  for (const std::string& file : outputs.files) {
    std::error_code error;
    if (fs::equivalent(file, options.model.model, error)) {
      printError("'" + file + "' is the model: give the output another name");
      return kUsage;
    }
    if (outputs.turntable > 0 && !isPng(file)) {
      printError("'" + file + "' is not seen from a side: --turntable writes .png, .mp4, .webm and .gif");
      return kUsage;
    }
  }
  if (outputs.render.isOn && options.movies.empty() && std::ranges::none_of(outputs.files, isPng)) {
    printError("--render draws .png, .mp4, .webm and .gif: give -o such a file");
    return kUsage;
  }
  return kSuccess;
}

int run(RunOptions& options) {
  if (options.runsAll) {
    return runAll(options);
  }
  if (const int status = takeMovies(options); status != kSuccess) {
    return status;
  }
  if (const int status = checkFiles(options); status != kSuccess) {
    return status;
  }
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
      "The suffix of an output file chooses its format; the help of --format lists all formats.\n"
      "A model folder defines the colours, the environment and, with -a, the last step.\n"
      "Examples:\n"
      "  espalier run lilac -o lilac.png --size 1920x1080\n"
      "  espalier run tree.l -o tree.glb -o tree.png -o tree.mtg\n"
      "  espalier run tree.l --render -o tree.png --size 1200x1200 --sun 35,-60   in the light of sun and sky\n"
      "  espalier run tree.l --every -o frame.png            frame-0000.png, frame-0001.png, ...\n"
      "  espalier run tree.l --every -o growth.mp4           a movie, by ffmpeg; also .webm and .gif\n"
      "  espalier run tree.l --turntable 48 --render -o turn.gif\n"
      "  espalier run forest.json -o stand.png               several plants, of several models, in one environment\n"
      "  espalier run curves.l --all -o sheet.png            a contact sheet of the models in a file\n"
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
  CLI::Option* resume = command->add_option(
      "--resume", options->resumed, "Continue from a snapshot. The snapshot holds its model, so MODEL is not needed");
  resume->type_name("FILE.snapshot");
  CLI::Option* every = command->add_flag(
      "--every", options->writesEveryStep,
      "Write every step, from 0. The number of the step replaces %d or %04d in the file name, or stands before the\n"
      "suffix. A .usda file without %d holds the growth animation of all steps");
  addWholeNumber(*command, "--turntable",
                 "Write N pictures of one turn of the plant at its last step, numbered from 0. -o FILE.mp4, .webm or\n"
                 ".gif makes a movie of them, or with --every of the growth; the program ffmpeg makes it",
                 2, 10'000, [options](std::uint64_t count) { options->outputs.turntable = count; })
      ->type_name("N")
      ->excludes(every);
  addWholeNumber(*command, "--frame-rate", "Pictures a second of a movie (12)", 1, 120, [options](std::uint64_t count) {
    options->framesPerSecond = static_cast<unsigned>(count);
  })->type_name("N");
  command
      ->add_option_function<std::string>(
          "--frames", [options](const std::string& name) { options->hasSharedFrame = name == "shared"; },
          "With --every, the scale of fitted pictures: shared (one scale for all frames; the run is made twice) or\n"
          "own (each frame as large as the page allows). Default: shared, or own with an environment in another\n"
          "process")
      ->check(CLI::IsMember({"shared", "own"}))
      ->needs(every);
  CLI::Option* variants =
      addWholeNumber(*command, "--variants",
                     "Grow N plants with the seeds S, S+1, ... of --seed S (1); files are numbered from 001", 1,
                     1'000'000, [options](std::uint64_t count) { options->variants = count; })
          ->type_name("N")
          ->excludes("--turntable")
          ->excludes(every)
          ->excludes(resume);
  command
      ->add_flag("--all", options->runsAll,
                 "Of a file with several models, draw every one into one picture (.png); --size is that of a cell\n"
                 "(320x240)")
      ->excludes(every)
      ->excludes(variants)
      ->excludes(resume);
  command
      ->add_option(
          "--in-rows", options->rowSpacing,
          "Write all variants into one file, in rows with this distance (0: so that they do not touch). Equal plants\n"
          "share their meshes in a .glb")
      ->type_name("DISTANCE")
      ->check(numberFrom(0.0, 1e300))
      ->needs(variants);
  command->callback([options, &status] {
    if (options->model.model.empty() && roots::isRootFile(options->model.startFile)) {
      options->model.model = std::exchange(options->model.startFile, {});
    }
    if (options->model.model.empty() && options->resumed.empty()) {
      throw CLI::RequiredError("MODEL (or --resume FILE.snapshot)");
    }
    options->outputs.picture.threads = options->model.threadCount();
    status = run(*options);
  });
}

}  // namespace espalier::command
