#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/json_file.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/output/progress_bar.h"
#include "clients/espalier/sweep/export_table.h"
#include "clients/espalier/sweep/run_pipe.h"
#include "clients/espalier/sweep/slurm_job.h"
#include "clients/espalier/sweep/sweep.h"
#include "clients/espalier/world_file.h"
#include "environment/registry.h"
#include "server/remote/control_group.h"
#include "server/remote/disk_files.h"
#include "server/remote/limits.h"
#include "server/remote/models/gallery.h"
#include "server/remote/partial_file.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

// the plan comes from standard input: all of it, or with --pipe its first line
constexpr const char* kStandardInput = "-";

struct SweepOptions {
  std::string plan;
  std::string output;
  unsigned workers = 0;  // 0: as many as the process may use
  Slice slice;
  bool isPiped = false;
  bool printsSchema = false;
  bool printsTable = false;
  bool usesSlurm = false;
  std::uint64_t slices = 0;
  std::vector<std::string> jobOptions;
  std::string world, stepDuration;  // in place of the plan's; empty: the plan's
  bool isQuiet = false;
  bool allowsFolderPrograms = false;

  [[nodiscard]] unsigned workerCount() const { return workers > 0 ? workers : server::processorCount(); }
};

std::atomic<bool> isInterrupted{false};

// the first signal lets the running runs finish; the second ends the program
void noteSignal(int signal) {
  isInterrupted = true;
  server::removePartialFilesAtSignal(signal);
}

// a name of the plan: in the folder of the plan, in the working folder, or of the gallery
std::string foundFile(const std::string& name, const std::string& folder, bool isModel) {
  std::error_code error;
  const fs::path beside = fs::path(folder) / name;
  if (fs::exists(beside, error)) {
    return beside.lexically_normal().string();
  }
  return isModel ? server::pathOrGallery(name) : name;
}

/// A plan with everything that its runs need.
struct Prepared {
  Plan plan;
  std::string file;
  std::string folder;
  RunTable table;
};

// standard input: all of it, or the first line, after which it carries binary requests
std::string readStandardInput(bool isLine) {
  std::string text;
  for (int c = std::getchar(); c != EOF && !(isLine && c == '\n'); c = std::getchar()) {
    text += static_cast<char>(c);
  }
  return text;
}

std::optional<Prepared> readPlanFile(const std::string& file, bool isPiped) {
  server::DiskFileProvider files;
  const bool isRead = file == kStandardInput;
  const std::optional<std::string> text = isRead ? readStandardInput(isPiped) : files.read(file);
  if (!text) {
    printError("there is no plan '" + file + "': check the name and the working folder");
    return std::nullopt;
  }
  Result<Plan> plan = readPlan(*text);
  if (!plan) {
    printError((isRead ? "the plan" : file) + ": " + plan.error());
    return std::nullopt;
  }
  Prepared prepared{
      .plan = std::move(*plan), .file = file, .folder = fs::path(file).parent_path().string(), .table = {}};
  if (!isPiped) {
    Result<RunTable> table = makeRuns(prepared.plan, prepared.folder, files);
    if (!table) {
      printError(file + ": " + table.error());
      return std::nullopt;
    }
    prepared.table = std::move(*table);
  }
  return prepared;
}

// the environment of a plan or of its model; prints an error and returns false
bool findEnvironment(SweepInput& input, const std::string& planFile, const ModelOptions& model,
                     core::FileProvider& files) {
  const std::string folder = fs::path(planFile).parent_path().string();
  const std::string& own = input.plan.environment;
  std::string text = own.starts_with('{') || own.starts_with('[') ? own : "";
  std::string file = text.empty() ? (own.empty() ? model.environment : foundFile(own, folder, false)) : "the plan";
  // a plan beside the model with its name is no environment
  std::error_code error;
  if (file.empty() || (own.empty() && fs::equivalent(file, planFile, error))) {
    return true;
  }
  if (text.empty() && environment::findProcess(file) != nullptr) {
    input.configuration = "{\"type\":\"" + file + "\"}";
    return true;
  }
  if (text.empty() && fs::path(file).extension() == ".json") {
    text = files.read(file).value_or("");
  }
  if (!text.empty()) {
    Result<std::string> configuration = readConfiguration(text, file, files);
    if (!configuration) {
      printError(configuration.error());
      return false;
    }
    input.configuration = std::move(*configuration);
  }
  if (input.configuration.empty()) {
    RemoteOptions remote = model.remote;
    remote.source = own.empty() ? remote.source : EnvironmentSource::Folder;
    input.environmentMaker = [file, model, remote]() -> std::unique_ptr<turtle::EnvironmentProcess> {
      server::DiskFileProvider disk;
      std::optional<LoadedEnvironment> loaded = loadEnvironment(file, model.mode(), true, disk, remote);
      return loaded ? std::move(loaded->process) : nullptr;
    };
  }
  return true;
}

// the world of the options, of the plan or of the model's folder; prints errors
std::optional<ChosenWorld> worldOfSweep(const Prepared& prepared, const SweepOptions& sweep, const ModelOptions& model,
                                        core::FileProvider& files) {
  const Plan& plan = prepared.plan;
  ModelOptions options;
  options.model = model.model;
  options.world = sweep.world;
  options.stepDuration = sweep.stepDuration.empty() ? plan.stepDuration : sweep.stepDuration;
  const bool isInPlan = options.world.empty() && plan.world.starts_with('{');
  if (!isInPlan) {
    const std::string file = plan.world.empty() || !options.world.empty()
                                 ? worldFileOf(options)
                                 : foundFile(plan.world, prepared.folder, false);
    return chooseWorld(options, file, files);
  }
  core::MemoryFileProvider memory;
  const std::string name = prepared.file + ": world";
  memory.add(name, plan.world);
  auto record = decodeJsonFile(name, "world", memory, protocol::decodeWorld, false);
  const auto complete = record ? completeRecord(std::move(*record), prepared.file, options, files) : std::nullopt;
  auto world = complete ? worldOf(*complete, name) : std::nullopt;
  return world ? std::optional(ChosenWorld{std::move(*world), worldText(*complete)}) : std::nullopt;
}

// the model of a plan with everything that its runs share; prints errors
std::unique_ptr<SweptModel> loadSweptModel(Prepared& prepared, const SweepOptions& sweep, core::FileProvider& files) {
  const Plan& plan = prepared.plan;
  ModelOptions options;
  options.model = foundFile(plan.model, prepared.folder, true);
  options.object = plan.object;
  options.view = plan.view.empty() ? "" : foundFile(plan.view, prepared.folder, false);
  options.dialect = plan.dialect;
  options.compatibility = plan.compatibility;
  options.limits = plan.limits;
  options.isQuiet = sweep.isQuiet;
  options.remote.allowsFolderPrograms = sweep.allowsFolderPrograms;
  for (const std::string& limit : plan.limits) {
    server::ServerLimits limits;
    if (const auto mistake = server::setLimit(limits, limit)) {
      printError("limits: " + *mistake);
      return nullptr;
    }
  }
  for (const auto& [name, value] : plan.defines) {
    options.defines.push_back(name + "=" + value);
  }
  server::FolderSettings folder;
  const std::shared_ptr<const language::Program> program = loadProgram(options, files, &folder);
  if (!program) {
    return nullptr;
  }
  SweepInput input;
  input.plan = plan;
  input.model.modelFile = program->modelFile;
  input.model.viewFile = options.view;
  input.model.dialect = options.dialect;
  input.model.compatibility = options.mode();
  input.model.limits = options.simulationLimits();
  input.model.defines = plan.defines;
  input.palette = folder.palette;
  if (!findEnvironment(input, prepared.file, options, files)) {
    return nullptr;
  }
  auto world = worldOfSweep(prepared, sweep, options, files);
  if (!world) {
    return nullptr;
  }
  input.world = std::move(world->world);
  input.worldText = std::move(world->text);
  const std::span<const double> first = prepared.table.count() == 0 ? std::span<const double>() : prepared.table.row(0);
  Result<std::unique_ptr<SweptModel>> model = SweptModel::make(std::move(input), first, files);
  if (!model) {
    printError(model.error());
    return nullptr;
  }
  return std::move(*model);
}

// writes the files that a plan keeps, into a folder beside the results
PlantVisitor keptFiles(const Plan& plan, const std::string& folder) {
  if (plan.files.empty()) {
    return {};
  }
  return [&plan, folder](const simulation::Simulation& plant, std::uint64_t run) -> std::optional<std::string> {
    for (const KeptFile& file : plan.files) {
      if (run % file.every != 0) {
        continue;
      }
      OutputOptions options;
      options.files = {numberedName((fs::path(folder) / file.name).string(), run, 6)};
      if (!OutputWriter(options, true).write(plant)) {
        return "the file '" + options.files.front() + "' could not be written";
      }
    }
    return std::nullopt;
  };
}

// the folder of the files that a plan keeps; prints an error and returns nothing when it cannot be made
std::optional<std::string> folderOfFiles(const Plan& plan, const std::string& output) {
  const std::string folder = fs::path(output).replace_extension(".files").string();
  if (plan.files.empty()) {
    return folder;
  }
  OutputOptions options;
  std::error_code error;
  fs::create_directories(folder, error);
  for (const KeptFile& file : plan.files) {
    options.files.push_back((fs::path(folder) / file.name).string());
  }
  return checkOutputs(options) == kSuccess ? std::optional(folder) : std::nullopt;
}

std::string durationText(double seconds) {
  const auto whole = static_cast<std::uint64_t>(seconds + 0.5);
  if (whole < 120) {
    return std::to_string(whole) + " s";
  }
  return whole < 7200 ? std::to_string(whole / 60) + " min" : std::to_string(whole / 3600) + " h";
}

/// Shows how far a sweep has come: a line that is redrawn on a terminal, else a line for each tenth.
class SweepReport {
 public:
  explicit SweepReport(bool isQuiet) : isQuiet_(isQuiet), bar_(!isQuiet) {}

  void show(const SweepProgress& progress) {
    std::string line = std::to_string(progress.done) + " of " + std::to_string(progress.total) + " runs";
    const auto made = static_cast<double>(progress.done - progress.started);
    if (made > 0.0 && progress.done < progress.total) {
      line +=
          ", " + durationText(progress.seconds / made * static_cast<double>(progress.total - progress.done)) + " left";
    }
    if (progress.failed > 0) {
      line += ", " + std::to_string(progress.failed) + " failed";
    }
    bar_.showLine(line);
    const std::uint64_t tenth = progress.total == 0 ? 10 : progress.done * 10 / progress.total;
    if (!isQuiet_ && isatty(STDERR_FILENO) == 0 && tenth > tenth_) {
      printNote(line);
    }
    tenth_ = tenth;
  }
  void clear() { bar_.clear(); }

 private:
  bool isQuiet_;
  std::uint64_t tenth_ = 0;
  ProgressBar bar_;
};

// the measures without a value: their cells are empty
void reportMissing(const SweepProgress& last, const std::vector<std::string>& columns) {
  constexpr std::size_t kMostLines = 5;
  const std::uint64_t ended = last.done - last.started - last.failed;
  std::size_t lines = 0;
  std::size_t more = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const MissingValues& missing = last.missing[i];
    if (missing.count > 0 && ++lines <= kMostLines) {
      printNote("the measure '" + columns[i] + "' has no value in " + std::to_string(missing.count) + " of " +
                std::to_string(ended) + " runs. The first is run " + std::to_string(missing.firstRun));
    } else if (missing.count > 0) {
      ++more;
    }
  }
  if (more > 0) {
    printNote("and " + std::to_string(more) + " more measures have no value in some runs");
  }
}

int finish(const SweepProgress& last, const SweepOptions& options, const std::vector<std::string>& columns) {
  const std::uint64_t made = last.done - last.started;
  if (last.failed > 0) {
    printNote(std::to_string(last.failed) + " of " + std::to_string(made) + " runs failed. The first is run " +
              std::to_string(last.firstFailed) + ": " + last.firstError);
  }
  if (!last.firstWarning.empty()) {
    printNote("warning in run " + std::to_string(last.firstWarned) + " and perhaps in others: " + last.firstWarning);
  }
  if (!options.isQuiet) {
    reportMissing(last, columns);
  }
  if (last.done < last.total) {
    printNote("stopped: '" + options.output + "' has " + std::to_string(last.done) + " of " +
              std::to_string(last.total) + " runs. The same command continues");
    return kFailure;
  }
  if (!options.isQuiet) {
    printNote("'" + options.output + "' has " + (options.slice.count > 1 ? "the slice with " : "all ") +
              std::to_string(last.total) + " runs" +
              (made == last.total ? "" : ", " + std::to_string(made) + " of them new"));
  }
  if (made > 0 && last.failed == made) {
    printError("no run reached its end: correct the model or the plan, and remove '" + options.output + "'");
    return kFailure;
  }
  return kSuccess;
}

int runPlan(const SweepOptions& options) {
  std::optional<Prepared> prepared = readPlanFile(options.plan, options.isPiped);
  if (!prepared) {
    return kFailure;
  }
  if (options.printsTable) {
    return printTable(prepared->plan, prepared->table) ? kSuccess : kFailure;
  }
  server::DiskFileProvider files;
  const std::unique_ptr<SweptModel> model = loadSweptModel(*prepared, options, files);
  if (!model) {
    return kFailure;
  }
  if (options.isPiped) {
    if (!servePipe(*model, options.workerCount())) {
      printError(
          "the other side of --pipe has sent a broken request, or has gone: it is meant for espalier.Model of Python");
      return kFailure;
    }
    return kSuccess;
  }
  const std::optional<std::string> folder = folderOfFiles(model->plan(), options.output);
  if (!folder) {
    return kFailure;
  }
  if (options.usesSlurm) {
    const Result<std::vector<std::string>> jobs = submitSlurmJob({.plan = options.plan,
                                                                  .output = options.output,
                                                                  .slices = options.slices,
                                                                  .options = options.jobOptions,
                                                                  .allowsFolderPrograms = options.allowsFolderPrograms,
                                                                  .world = options.world,
                                                                  .stepDuration = options.stepDuration});
    if (!jobs) {
      printError(jobs.error());
      return kFailure;
    }
    for (const std::string& job : *jobs) {
      std::printf("%s\n", job.c_str());
    }
    printNote("submitted " + std::to_string(options.slices) + " jobs; job " + jobs->back() +
              " merges their parts into '" + options.output + "'");
    return kSuccess;
  }
  std::signal(SIGINT, noteSignal);
  std::signal(SIGTERM, noteSignal);
  Result<SweepResults> results = SweepResults::continued(options.output, describeSweep(*model, prepared->table));
  if (!results) {
    printError(results.error());
    return kFailure;
  }
  SweepReport report(options.isQuiet);
  SweepProgress last;
  const auto problem = runSweep(
      *model, prepared->table, options.slice, options.workerCount(), *results, keptFiles(model->plan(), *folder),
      isInterrupted, [&report](const SweepProgress& progress) { report.show(progress); }, last);
  report.clear();
  if (problem) {
    printError(*problem);
    return kFailure;
  }
  return finish(last, options, model->measureColumns());
}

int run(const SweepOptions& options) {
  if (options.printsSchema) {
    std::fwrite(planSchema().data(), 1, planSchema().size(), stdout);
    return kSuccess;
  }
  if (options.plan.empty()) {
    printError("give a PLAN.json, or one of the commands export and merge; `espalier sweep --help` has an example");
    return kUsage;
  }
  if (options.output.empty() && !options.isPiped && !options.printsTable) {
    printError("give a file for the results: -o results.sqlite");
    return kUsage;
  }
  if (const std::string suffix = fs::path(options.output).extension().string(); suffix == ".csv" || suffix == ".tsv") {
    printError(
        "the results are a file of SQLite: give -o results.sqlite, and make the table with espalier sweep export " +
        std::string("results.sqlite -o ") + options.output);
    return kUsage;
  }
  if (options.usesSlurm && options.plan == kStandardInput) {
    printError("the jobs of --slurm read the plan again: give it as a file");
    return kUsage;
  }
  if (options.usesSlurm != (options.slices > 0)) {
    printError("--slurm needs --slices N, the number of jobs of the array, and --slices needs --slurm");
    return kUsage;
  }
  return runPlan(options);
}

void addExportCommand(CLI::App& sweep, int& status) {
  struct SweepExport {
    std::string file, output;
    bool isPartial = false;
  };
  const auto options = std::make_shared<SweepExport>();
  CLI::App* command = sweep.add_subcommand("export", "Print the results as a table, by the number of the run");
  command->footer(
      "The table has no times. So two tables are equal, byte by byte, when their sweeps are.\n"
      "Example:\n"
      "  espalier sweep export results.sqlite -o results.csv");
  command->add_option("results", options->file, "Results of a sweep")->required()->type_name("FILE.sqlite");
  command->add_option("-o,--output", options->output,
                      "A file; its suffix chooses the form: .csv or .tsv (default: CSV on standard output)");
  command->add_flag("--partial", options->isPartial, "Also when runs are missing");
  command->callback([options, &status] {
    const auto problem = exportTable(options->file, options->output, options->isPartial);
    if (problem) {
      printError(*problem);
    }
    status = problem ? kFailure : kSuccess;
  });
}

void addMergeCommand(CLI::App& sweep, int& status) {
  struct MergeOptions {
    std::vector<std::string> files;
    std::string output;
  };
  const auto options = std::make_shared<MergeOptions>();
  CLI::App* command = sweep.add_subcommand("merge", "Put the results of slices into one file");
  command->footer(
      "Example:\n"
      "  espalier sweep merge part-*.sqlite -o results.sqlite");
  command->add_option("results", options->files, "Results of slices of one plan")->required()->type_name("FILE.sqlite");
  command->add_option("-o,--output", options->output, "The file for all results")->required()->type_name("FILE.sqlite");
  command->callback([options, &status] {
    const auto problem = mergeResults(options->files, options->output);
    if (problem) {
      printError(*problem);
    }
    status = problem ? kFailure : kSuccess;
  });
}

}  // namespace

void addSweep(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("sweep", "Run a model many times with other parameters, and keep measures");
  command->footer(
      "A plan names a model, the parameters that change, the runs (a table or a design) and measures. docs/sweeps.md\n"
      "explains it. The same command continues a sweep that was stopped. Examples:\n"
      "  espalier sweep plan.json -o results.sqlite\n"
      "  espalier sweep plan.json -o part-3.sqlite --slice 3/64      one of 64 parts, for a scheduler\n"
      "  espalier sweep merge part-*.sqlite -o results.sqlite\n"
      "  espalier sweep export results.sqlite -o results.csv");
  const auto options = std::make_shared<SweepOptions>();
  command->add_option("plan", options->plan, "The plan; -: from standard input")->type_name("PLAN.json");
  command->add_option("-o,--output", options->output, "File of the results, an SQLite database")
      ->type_name("FILE.sqlite");
  addWholeNumber(*command, "--workers", "Runs at the same time; 0: as many as the process may use processors", 0, 4096,
                 [options](std::uint64_t workers) { options->workers = static_cast<unsigned>(workers); })
      ->type_name("N");
  command
      ->add_option_function<std::string>(
          "--slice", [options](const std::string& text) { options->slice = *readSlice(text); },
          "Only the k-th of n parts of the runs")
      ->type_name("k/n")
      ->check([](const std::string& text) {
        const Result<Slice> slice = readSlice(text);
        return slice ? std::string() : slice.error();
      });
  command->add_flag("--table", options->printsTable, "Only print the runs: their numbers, seeds and parameters");
  command->add_flag("--schema", options->printsSchema, "Only print the JSON Schema of plans");
  command->add_flag("--pipe", options->isPiped,
                    "Read parameters from standard input and write measures to standard output, for programs "
                    "(docs/sweeps.md). The plan\n"
                    "may be -, the first line of standard input");
  command->add_flag("--slurm", options->usesSlurm, "Submit the sweep as an array of Slurm jobs");
  addWholeNumber(*command, "--slices", "Jobs of the array", 1, 1'000'000, [options](std::uint64_t slices) {
    options->slices = slices;
  })->type_name("N");
  command->add_option("--job-option", options->jobOptions, "An option of sbatch, as --time=01:00:00. May be repeated")
      ->allow_extra_args(false);
  addWorldOptions(*command, options->world, options->stepDuration);
  command->add_flag(
      "--allow-folder-programs", options->allowsFolderPrograms,
      "The environment of the plan or of its model may start the programs and plug-ins, and dial the addresses,\n"
      "that it names: for plans that you trust");
  command->add_flag("--quiet", options->isQuiet, "Print only results, failures and errors");
  addExportCommand(*command, status);
  addMergeCommand(*command, status);
  command->callback([options, command, &status] {
    if (command->get_subcommands().empty()) {
      status = run(*options);
    }
  });
}

}  // namespace espalier::command
