#include "clients/espalier/model_loading.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <system_error>
#include <variant>

#include "clients/espalier/forest_file.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/folder_writer.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/world_file.h"
#include "engine/files/file_name.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "engine/turtle/export/text/mtg.h"
#include "protocol/codec.h"
#include "server/remote/control_group.h"
#include "server/remote/limits.h"
#include "server/remote/models/gallery.h"
#include "server/remote/models/model_files.h"
#include "server/remote/remote_settings.h"

namespace espalier::command {
namespace {

// the problem with a file that the command line names, or nothing
std::optional<std::string> whyUnreadable(const std::string& file, const char* option) {
  std::error_code error;
  if (std::filesystem::is_regular_file(file, error)) {
    return std::nullopt;
  }
  return std::string("there is no file '") + file + "' (" + option + "): check the name and the working folder";
}

// the first bracket of a string that has no partner
std::vector<core::Diagnostic> bracketWarnings(const std::string& file, std::string_view text) {
  std::vector<std::size_t> open;
  std::size_t alone = std::string_view::npos;
  for (std::size_t at = 0; at < text.size() && alone == std::string_view::npos; ++at) {
    if (text[at] == '[') {
      open.push_back(at);
    } else if (text[at] == ']' && open.empty()) {
      alone = at;
    } else if (text[at] == ']') {
      open.pop_back();
    }
  }
  if (alone == std::string_view::npos && open.empty()) {
    return {};
  }
  const bool isClosing = alone != std::string_view::npos;
  const std::size_t at = isClosing ? alone : open.back();
  const std::size_t begin = text.substr(0, at).rfind('\n') + 1;
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  return {{.severity = core::Severity::Warning,
           .message = std::string(isClosing ? "this ']' closes no '['" : "this '[' is not closed") + " in the string",
           .location = {.file = file,
                        .line = static_cast<std::uint32_t>(line),
                        .column = static_cast<std::uint32_t>(at - begin + 1),
                        .length = 1,
                        .lineText = std::string(text.substr(begin, text.find('\n', at) - begin)),
                        .expansion = {}},
           .hint = "a branch is opened and closed in the same string"}};
}

/// The root system of a file. Prints an error and returns nothing after it.
std::optional<roots::RootSystem> readRootFile(const std::string& file, bool isQuiet, core::FileProvider& files,
                                              const core::Limits& limits) {
  const std::optional<std::string> text = files.read(file);
  if (!text) {
    printError("'" + file + "' cannot be read, or is larger than 256 MB: check the name, or give a smaller file");
    return std::nullopt;
  }
  auto read = roots::readRoots(file, *text, roots::mostDrawnPoints(limits.maximumSourceBytes));
  if (!read) {
    printError(file + ", " + read.error());
    return std::nullopt;
  }
  // without lines there is an error where they are needed
  if (!read->remark.empty() && !isQuiet && read->hasLines()) {
    printNote("warning: '" + file + "': " + read->remark);
  }
  return std::move(*read);
}

// the string in a file; the file may be an MTG
std::optional<std::string> readStartString(const ModelOptions& options, const std::string& lengthUnit,
                                           core::FileProvider& files) {
  const std::string& file = options.startFile;
  const bool isQuiet = options.isQuiet;
  std::optional<std::string> text = files.read(file);
  if (!text) {
    printError("there is no file '" + file + "' (--from): check the name and the working folder");
    return std::nullopt;
  }
  if (std::filesystem::path(file).extension() == ".mtg") {
    auto read = turtle::readMtg(*text);
    if (const std::string* problem = std::get_if<std::string>(&read)) {
      printError(file + ":" + *problem);
      return std::nullopt;
    }
    const auto& [strings, modules, missing] = std::get<turtle::MtgStrings>(read);
    if (strings.size() != 1) {
      printError("'" + file + "' has " + std::to_string(strings.size()) +
                 " plants, and a run starts from one: give a file with one plant");
      return std::nullopt;
    }
    text = strings.front();
    if (!modules.empty() && !isQuiet) {
      printNote("'" + file + "' (--from) has the modules " + modules +
                (missing == 0 ? std::string()
                              : "; " + std::to_string(missing) +
                                    (missing == 1 ? " of their numbers is missing in the file and is 0"
                                                  : " of their numbers are missing in the file and are 0")));
    }
  }
  if (roots::isRootFile(file)) {
    std::optional<roots::RootSystem> roots = readRootFile(file, isQuiet, files, options.simulationLimits());
    if (!roots) {
      return std::nullopt;
    }
    const std::string ownUnit = roots->unit;
    if (const auto problem = roots::convertTo(*roots, lengthUnit)) {
      printError(file + ": " + *problem);
      return std::nullopt;
    }
    text = roots::stringOf(*roots);
    if (!isQuiet) {
      printNote("'" + file +
                "' (--from) has the modules @M(x,y,z), @R(x,y,z), !(diameter), F(length), ?E(age,order,…)" +
                (ownUnit == roots->unit
                     ? std::string()
                     : "; its lengths in " + ownUnit + " are converted to those of the world in " + roots->unit));
    }
  }
  if (text->find_first_not_of(" \t\r\n") == std::string::npos) {
    printError("'" + file + "' (--from) has no modules");
    return std::nullopt;
  }
  if (!printDiagnostics(bracketWarnings(file, *text), isQuiet, options.remote.isStrict)) {
    return std::nullopt;
  }
  return text;
}

/// The files of a time series whose name has a place for a number, as `day-%04d.rsml`, by their numbers.
std::map<std::uint64_t, std::string> filesOfSeries(const std::string& pattern) {
  namespace fs = std::filesystem;
  const std::string name = fs::path(pattern).filename().string();
  const fs::path folder = fs::path(pattern).parent_path();
  std::map<std::uint64_t, std::string> found;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::string other = entry.path().filename().string();
    const std::size_t first = name.find('%');
    const std::size_t digits = other.find_first_not_of("0123456789", first);
    std::uint64_t number = 0;
    const char* const end = other.data() + std::min(digits, other.size());
    if (first < other.size() && std::from_chars(other.data() + first, end, number).ptr == end &&
        numberedName(name, number, 0) == other) {
      found.emplace(number, (folder / other).string());
    }
  }
  return found;
}

/// The root system of a time series; `file` becomes the last of its files. The number of a file is its day, counted
/// from the first. Prints an error and returns nothing after it.
std::optional<roots::RootSystem> readRootSeries(std::string& file, bool isQuiet, core::FileProvider& files,
                                                const core::Limits& limits) {
  const std::map<std::uint64_t, std::string> found = filesOfSeries(file);
  if (found.empty()) {
    printError("there is no file '" + numberedName(file, 0, 0) +
               "', and none with another number: check the name and " + "the working folder");
    return std::nullopt;
  }
  std::vector<roots::DatedRoots> series;
  for (const auto& [number, name] : found) {
    std::optional<roots::RootSystem> roots = readRootFile(name, isQuiet, files, limits);
    if (!roots) {
      return std::nullopt;
    }
    series.push_back({static_cast<double>(number - found.begin()->first), std::move(*roots)});
  }
  auto joined = roots::joinSeries(std::move(series));
  if (!joined) {
    printError(file + ": " + joined.error());
    return std::nullopt;
  }
  file = found.rbegin()->second;
  return std::move(*joined);
}

/// Gives a root system in a file as the source of a model, and a view file that draws round lines.
class RootModelFiles final : public core::FileProvider {
 public:
  static constexpr const char* kViewSuffix = ".round-lines.v";

  RootModelFiles(core::FileProvider& files, std::string name, std::string model)
      : files_(files), name_(std::move(name)), model_(std::move(model)) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    if (name == name_) {
      return model_;
    }
    return name == name_ + kViewSuffix ? "line style: cylinder\n" : files_.read(name);
  }
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override {
    return files_.readInside(folder, name);
  }

 private:
  core::FileProvider& files_;
  std::string name_;
  std::string model_;
};

bool drawsRandom(const language::ProductionList& list) {
  return std::any_of(list.productions.begin(), list.productions.end(),
                     [](const language::Production& production) { return production.drawsRandom; });
}

constexpr std::string_view kSeconds = "seconds=";
// the server limit with the same unit and bounds
constexpr std::string_view kServerSeconds = "callSeconds";

std::string serverSeconds(std::string_view limit) {
  return std::string(kServerSeconds) + "=" + std::string(limit.substr(kSeconds.size()));
}

// a sentence about a limit that a run does not have, or an empty text
std::string problemOfLimit(const std::string& text) {
  server::ServerLimits limits;
  const bool isTime = text.starts_with(kSeconds);
  const server::LimitEntry* entry = server::findLimit(std::string_view(text).substr(0, text.find('=')));
  if (!isTime && entry != nullptr && !entry->isOfSimulation) {
    return "the limit " + std::string(entry->name) + " is a limit of servers, not of a run";
  }
  if (const std::size_t equals = text.find('='); !isTime && entry == nullptr && equals != std::string::npos) {
    std::vector<std::string_view> names{kSeconds.substr(0, kSeconds.size() - 1)};
    for (const server::LimitEntry& known : server::limitEntries()) {
      if (known.isOfSimulation) {
        names.push_back(known.name);
      }
    }
    const std::string name = text.substr(0, equals);
    return "there is no limit '" + name + "'. " + core::suggestName(name, names);
  }
  std::string problem = server::setLimit(limits, isTime ? serverSeconds(text) : text).value_or(std::string{});
  if (const std::size_t at = problem.find(kServerSeconds); isTime && at != std::string::npos) {
    problem.replace(at, kServerSeconds.size(), "seconds");
  }
  return problem;
}

// the names with their meanings and defaults
std::string limitHelp() {
  std::string text =
      "A limit of the run; an error names the limit that was reached. May be repeated. Names: seconds (processor time; "
      "0)";
  server::ServerLimits limits;
  limits.simulation = core::Limits{};
  for (const server::LimitEntry& entry : server::limitEntries()) {
    if (entry.isOfSimulation) {
      text += ",\n" + std::string(entry.name) + " (" + std::string(entry.meaning) + "; " +
              std::to_string(entry.get(limits)) + ")";
    }
  }
  return text;
}

}  // namespace

unsigned ModelOptions::threadCount() const {
  return threads > 0 ? threads : server::processorCount();
}

RemoteOptions ModelOptions::environmentOptions() const {
  RemoteOptions result = remote;
  result.threads = threadCount();
  return result;
}

core::Limits ModelOptions::simulationLimits() const {
  server::ServerLimits result;
  result.simulation = core::Limits{};
  for (const std::string& limit : limits) {
    static_cast<void>(server::setLimit(result, limit));
  }
  return result.simulation;
}

std::uint64_t ModelOptions::seconds() const {
  server::ServerLimits result;
  result.callSeconds = 0;
  for (const std::string& limit : limits) {
    if (limit.starts_with(kSeconds)) {
      static_cast<void>(server::setLimit(result, serverSeconds(limit)));
    }
  }
  return result.callSeconds;
}

core::Compatibility ModelOptions::mode() const {
  if (compatibility == "cpfg") {
    return core::Compatibility::Cpfg;
  }
  return compatibility == "cpfg-batch" ? core::Compatibility::CpfgBatch : core::Compatibility::Espalier;
}

namespace {

std::vector<std::string> dialectChoices() {
  const std::vector<std::string_view> names = language::dialectNames();
  return {names.begin(), names.end()};
}

}  // namespace

void addReadingOptions(CLI::App& command, ModelOptions& options, bool isModelRequired) {
  CLI::Option* model = command.add_option(
      "model", options.model,
      "An L-system file (.l, or a file of another dialect; FILE:ENTRY for one of several "
      "models in it),\na model folder, a forest (.json), a root system (.rsml, or a .tsv table), or the name of "
      "a\nmodel of the gallery that came with the program");
  model->type_name("MODEL");
  model->transform(server::pathOrGallery);
  model->required(isModelRequired);
  command.add_option("--dialect", options.dialect, "Dialect of the model (default: recognised by its content)")
      ->check(CLI::IsMember(dialectChoices()));
  command
      .add_option("--object", options.object,
                  "For a folder whose specifications list several models: title in the menu, model file or\n"
                  "number of one of them (default: the first)")
      ->type_name("TITLE");
  command.add_option("--view", options.view, "View file (default: the .v file beside the model with the same name)")
      ->type_name("FILE.v");
  command
      .add_option("--environment", options.environment,
                  "The environment that answers communication modules ?E: name of a built-in process,\n"
                  "environment file (.e), configuration (.json), plug-in (.so), tcp://HOST:PORT, unix:PATH\n"
                  "or stdio:COMMAND (default: beside the model the .e file, else the .json file of its name)")
      ->type_name("ENVIRONMENT");
  command
      .add_option("--compat", options.compatibility,
                  "Reproduce the program cpfg: its interactive run (cpfg) or its batch run (cpfg-batch)")
      ->check(CLI::IsMember({"cpfg", "cpfg-batch"}));
  command
      .add_option("--define", options.defines,
                  "A macro for the preprocessor; it wins over a #define of the model. May be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false)
      ->check([](const std::string& text) {
        return text.empty() || text.front() == '=' ? std::string("expected NAME=VALUE") : std::string{};
      });
  command.add_flag(
      "--allow-folder-programs", options.remote.allowsFolderPrograms,
      "The environment of a folder, forest or plan, and any environment file (.e), may start the programs\n"
      "and plug-ins, and dial the addresses, that it names: for folders that you trust. Without it only built-in\n"
      "environments answer");
  command.add_flag("--strict", options.remote.isStrict,
                   "A warning about a file of the model or the environment is an error");
  command.add_option("--limit", options.limits, limitHelp())
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false)
      ->check([](const std::string& text) { return problemOfLimit(text); });
  command.add_flag("--quiet", options.isQuiet, "Print only results and errors: no warnings, no seed, no progress");
}

void addRunningOptions(CLI::App& command, ModelOptions& options) {
  addWholeNumber(command, "--steps", "Number of steps instead of the model's derivation length (Z)", 0, kMaximumSteps,
                 [&options](std::uint64_t steps) { options.steps = steps; })
      ->type_name("N");
  command.add_flag("-a,--animate", options.isAnimated,
                   "The animation file of the folder decides which step is the last, as with its switch -a");
  command
      .add_option("--environment-policy", options.remote.policy,
                  "When an environment in another process or a plug-in fails: fail (the step fails), keep (the\n"
                  "modules keep their values) or fallback:NAME (a built-in environment answers)")
      ->type_name("POLICY")
      ->check([](const std::string& words) {
        const auto read = server::readRemotePolicy(words);
        return read ? std::string{} : read.error();
      });
  command
      .add_option("--environment-timeout", options.remote.timeoutSeconds,
                  "Longest time of an environment for a step (default: 60 for another process or a plug-in, no\n"
                  "limit for a built-in environment)")
      ->type_name("SECONDS")
      ->check(numberFrom(0.001, 86'400.0));
  addWholeNumber(
      command, "--iterations",
      "In each step, ask the environment again with its own answers until they no longer change, at\n"
      "most N times (1: no repetition)",
      1, 10'000,
      [&options](std::uint64_t iterations) { options.coupling.iterations = static_cast<std::uint32_t>(iterations); })
      ->type_name("N");
  command
      .add_option("--tolerance", options.coupling.tolerance,
                  "With --iterations: an answer that differs by at most X counts as unchanged (0)")
      ->type_name("X")
      ->check(numberFrom(0.0, 1e300));
  addWholeNumber(command, "--seed", "Seed of the random numbers; it replaces the model's `seed:`", 0,
                 std::numeric_limits<std::uint64_t>::max(), [&options](std::uint64_t seed) { options.seed = seed; })
      ->type_name("S");
  command
      .add_option("--from", options.startFile,
                  "A string that replaces the axiom: a file of `run -o NAME.string`, an MTG (.mtg), or a root\n"
                  "system (.rsml, or a .tsv table)")
      ->type_name("FILE");
  addWorldOptions(command, options.world, options.stepDuration);
  command
      .add_option("--threads", options.threads,
                  "Threads for strings of more than 65536 modules and for the rays of the environment 'light';\n"
                  "0: as many as the process may use processors. The result does not depend on their number")
      ->type_name("N")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
}

void addWorldOptions(CLI::App& command, std::string& world, std::string& stepDuration) {
  command
      .add_option("--world", world,
                  "The world: units, up and north, duration of a step, place, start and weather (.json; default:\n"
                  "world.json of the model folder, or of the forest)")
      ->type_name("FILE");
  command
      .add_option("--step-duration", stepDuration,
                  "Time of a step, such as \"1 h\", \"0.25 d\" or \"30 min\" (default: the world's, or one day)")
      ->type_name("TIME")
      ->check([](const std::string& text) {
        const auto days = protocol::daysOfDuration(text);
        return days && *days > 0.0
                   ? std::string{}
                   : "'" + text + "' is not a time: give one above 0, such as \"1 h\", \"0.25 d\" or \"30 min\"";
      });
}

std::pair<std::string, std::string> splitDefine(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    return {text, "1"};
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

bool drawsRandomNumbers(const language::Program& program) {
  return std::any_of(program.systems.begin(), program.systems.end(), [](const language::LSystem& system) {
    return system.isStochastic || system.blocksDrawRandom || drawsRandom(system.productions) ||
           drawsRandom(system.decomposition) || drawsRandom(system.homomorphism);
  });
}

bool needsDrawnSeed(const language::Program& program) {
  return program.compatibility == core::Compatibility::Espalier && !program.systems.front().seed &&
         drawsRandomNumbers(program);
}

std::vector<std::string> modelEntries(const ModelOptions& options, core::FileProvider& files) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(options.model, error)) {
    return {};
  }
  language::CompileInput input;
  input.modelFile = options.model;
  input.dialect = options.dialect;
  input.limits = options.simulationLimits();
  return language::entriesOf(input, files);
}

std::shared_ptr<const language::Program> loadProgram(ModelOptions& options, core::FileProvider& files,
                                                     server::FolderSettings* folder) {
  std::optional<roots::RootSystem> roots;
  std::error_code error;
  const bool isSeries = roots::isRootFile(options.model) && options.model.find('%') != std::string::npos &&
                        !std::filesystem::is_regular_file(options.model, error);
  if (isSeries && !(roots = readRootSeries(options.model, options.isQuiet, files, options.simulationLimits()))) {
    return nullptr;
  }
  const server::FoundModel found = server::findModelFiles(options.model, options.object);
  if (!found) {
    printError(found.error());
    return nullptr;
  }
  const server::ModelFiles& modelFiles = *found;
  core::DiagnosticList remarks;
  for (const core::Diagnostic& remark : modelFiles.remarks) {
    remarks.add(remark);
  }
  if (folder != nullptr) {
    *folder = server::readFolderSettings(modelFiles, options.isAnimated, files, remarks);
  }
  if (!printDiagnostics(remarks.entries(), options.isQuiet, options.remote.isStrict)) {
    return nullptr;
  }
  if (options.view.empty()) {
    options.view = modelFiles.view;
  } else if (const auto problem = whyUnreadable(options.view, "--view")) {
    printError(*problem);
    return nullptr;
  }
  if (options.environment.empty()) {
    options.environment = modelFiles.environment;
    options.remote.source = EnvironmentSource::Folder;
  }

  std::optional<RootModelFiles> rootFiles;
  if (roots::isRootFile(modelFiles.model)) {
    if (!roots && !(roots = readRootFile(modelFiles.model, options.isQuiet, files, options.simulationLimits()))) {
      return nullptr;
    }
    if (!roots->hasLines()) {
      printError(modelFiles.model + (roots->nodes.empty()
                                         ? ": it has no roots. Give a file with the points of at least one root"
                                         : ": its roots have no length, so there is nothing to draw. Give a file with "
                                           "two points of at least one root"));
      return nullptr;
    }
    if (options.lengthUnit.empty()) {
      options.lengthUnit = roots->unit;
    }
    auto problem = roots::convertTo(*roots, options.lengthUnit);
    problem = problem ? problem : roots::problemOfDays(*roots);
    if (problem) {
      printError(modelFiles.model + ": " + *problem);
      return nullptr;
    }
    std::string model = roots::modelOf(*roots);
    if (const std::uint64_t most = options.simulationLimits().maximumSourceBytes; model.size() > most) {
      printError(modelFiles.model + ": its " + std::to_string(roots->nodes.size()) +
                 " points are more than can be drawn: 'espalier traits' measures more, and --limit sourceBytes=" +
                 std::to_string(model.size()) + " lets them be drawn");
      return nullptr;
    }
    rootFiles.emplace(files, modelFiles.model, std::move(model));
    options.rootLabels = std::make_shared<turtle::RsmlLabels>(roots::labelsOf(*roots));
    options.view += options.view.empty() ? modelFiles.model + RootModelFiles::kViewSuffix : "";
  }
  language::CompileInput input;
  input.modelFile = modelFiles.model;
  input.viewFile = options.view;
  input.dialect = options.dialect;
  input.compatibility = options.mode();
  input.limits = options.simulationLimits();
  input.beginsElsewhere = !options.startFile.empty();
  for (const std::string& define : options.defines) {
    input.defines.push_back(splitDefine(define));
  }
  language::CompileResult result =
      language::compile(input, rootFiles ? static_cast<core::FileProvider&>(*rootFiles) : files);
  if (!printDiagnostics(result.diagnostics.entries(), options.isQuiet, options.remote.isStrict)) {
    return nullptr;
  }
  if (!result.program && !result.diagnostics.hasErrors()) {
    printError("'" + input.modelFile + "' could not be read: check that it is readable");
  }
  return result.program;
}

simulation::SimulationOptions simulationOptionsFor(const ModelOptions& options, const language::Program& program) {
  simulation::SimulationOptions result;
  result.name = std::filesystem::path(program.modelFile).stem().string();
  result.derivationLength = options.steps;
  result.threads = options.threadCount();
  result.coupling = options.coupling;
  result.limits = options.simulationLimits();
  result.messages = standardErrorMessages(options.isQuiet);
  // the folder of a model from a snapshot may not exist here: the model then writes into the working folder
  const std::string folder = files::folderOf(program.modelFile);
  std::error_code error;
  result.fileWriter =
      std::make_shared<FolderWriter>(std::filesystem::is_directory(folder, error) ? folder : std::string{});
  if (options.seed) {
    result.seed = *options.seed;
    result.hasSeed = true;
  } else if (needsDrawnSeed(program)) {
    result.seed = std::random_device{}();
    result.hasSeed = true;
    if (!options.isQuiet) {
      printNote("seed " + std::to_string(result.seed));
    }
  }
  return result;
}

std::optional<LoadedModel> loadModel(ModelOptions& options, core::FileProvider& files) {
  if (const auto forest = forestFileOf(options.model)) {
    return loadForest(*forest, options, files);
  }
  const std::string worldFile = worldFileOf(options);
  auto world = loadWorld(options, worldFile, files);
  if (!world) {
    return std::nullopt;
  }
  if (!options.world.empty() || !worldFile.empty()) {
    options.lengthUnit = world->lengthUnit;
  }
  LoadedModel loaded;
  loaded.program = loadProgram(options, files, &loaded.folder);
  if (!loaded.program) {
    return std::nullopt;
  }
  loaded.programs = {loaded.program};
  loaded.plants.resize(1);
  if (!options.environment.empty()) {
    std::optional<LoadedEnvironment> environment =
        loadEnvironment(options.environment, options.mode(), options.isQuiet, files, options.environmentOptions());
    if (!environment) {
      return std::nullopt;
    }
    loaded.environment = std::move(*environment);
    if (!warnAboutUnaskedEnvironment(*loaded.program, options.isQuiet, options.remote.isStrict)) {
      return std::nullopt;
    }
  }
  // the queries of a root file are there for the environments that may be given
  const bool isAsked = !roots::isRootFile(options.model) || !options.environment.empty();
  if (isAsked &&
      !warnAboutUnansweredQueries(*loaded.program, options.environment.empty() ? nullptr : &loaded.environment,
                                  options.isQuiet, options.remote.isStrict)) {
    return std::nullopt;
  }
  if (!options.lengthUnit.empty()) {
    world->lengthUnit = options.lengthUnit;
  }
  loaded.simulationOptions = simulationOptionsFor(options, *loaded.program);
  loaded.simulationOptions.world = std::move(*world);
  loaded.simulationOptions.environmentOrigin = loaded.environment.origin;
  loaded.simulationOptions.palette = loaded.folder.palette;
  if (!options.startFile.empty()) {
    std::optional<std::string> start = readStartString(options, loaded.simulationOptions.world.lengthUnit, files);
    if (!start) {
      return std::nullopt;
    }
    loaded.simulationOptions.startString = std::move(*start);
  }
  return loaded;
}

}  // namespace espalier::command
