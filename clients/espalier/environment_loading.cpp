#include "clients/espalier/environment_loading.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "clients/espalier/json_place.h"
#include "clients/espalier/messages.h"
#include "engine/files/utf8.h"
#include "engine/language/checks/model_queries.h"
#include "environment/environment_entries.h"
#include "environment/environment_set.h"
#include "environment/idle_keys.h"
#include "environment/published/environment_file.h"
#include "environment/published/published_environment.h"
#include "environment/registry.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "server/remote/processes/legacy_process.h"
#include "server/remote/processes/plugin_library.h"
#include "server/remote/processes/supervised_process.h"
#include "server/remote/remote_environment.h"
#include "server/remote/remote_settings.h"
#include "server/remote/terrain/terrain_embedding.h"

namespace espalier::command {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

bool startsWith(const std::string& text, const char* prefix) {
  return text.rfind(prefix, 0) == 0;
}

/// The object of a file that a message is about. No name: there is no file.
struct FilePart {
  std::string name;
  std::string text;
  std::string path;  // of the object in the text: empty, or [1]

  // the message with its place in front
  [[nodiscard]] std::string placed(const std::string& message) const {
    return name.empty() ? message : name + jsonPlaceOfMessage(text, path, message) + ": " + message;
  }
};

// the process, or null after the errors are printed, each with its place in the file
Process orPrintErrors(environment::ProcessOrErrors&& made, const FilePart& part) {
  if (made) {
    return std::move(*made);
  }
  for (core::Diagnostic& error : made.error()) {
    if (error.location.file.empty()) {
      error.message = part.placed(error.message);
    }
  }
  printDiagnostics(made.error(), false);
  return nullptr;
}

/// The parts of the command line that every environment needs.
struct Making {
  const RemoteOptions& remote;
  std::shared_ptr<server::FailureSink> onFailure;
  bool isQuiet = false;
};

// the longest time of a step: from the entry, else from the command line, else `otherwise`
std::chrono::milliseconds timeOfStep(const Making& making, std::optional<std::chrono::milliseconds> ofEntry,
                                     std::chrono::milliseconds otherwise) {
  const double seconds = making.remote.timeoutSeconds;
  const auto asked = std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1e3));
  return ofEntry.value_or(seconds > 0.0 ? asked : otherwise);
}

// `entryJson` has the settings of an entry; errors begin with `what`
std::optional<server::RemoteSettings> readSettings(const std::string& entryJson, const std::string& what,
                                                   const Making& making) {
  auto read = server::readRemoteSettings(entryJson, making.remote.policy);
  if (!read) {
    printError(what + read.error().key + ": " + read.error().message);
    return std::nullopt;
  }
  return std::move(*read);
}

// prints the reason when a program, plug-in or address that `what` names may not be used
bool isTrusted(const std::string& verb, const std::string& what, const Making& making) {
  if (making.remote.source == EnvironmentSource::Snapshot) {
    printError("the snapshot asks to " + verb + " '" + what +
               "', and a snapshot may come from a stranger: give the environment with --environment if you trust it");
    return false;
  }
  if (making.remote.source == EnvironmentSource::Folder && !making.remote.allowsFolderPrograms) {
    printError("the environment of the folder, forest or plan asks to " + verb + " '" + what +
               "', and it may come from a stranger: --allow-folder-programs " + verb +
               "s it, for folders that you trust");
    return false;
  }
  return true;
}

// a command or a plug-in
bool mayStart(const std::string& what, const Making& making) {
  return isTrusted("start", what, making);
}

Process connectRemote(const std::string& address, const std::string& entryJson, const std::string& what,
                      const Making& making) {
  // a stranger's file may ask for an address of the user's own network, also of this machine
  if (startsWith(address, "stdio:") ? !mayStart(address, making) : !isTrusted("dial", address, making)) {
    return nullptr;
  }
  auto read = readSettings(entryJson, what, making);
  if (!read) {
    return nullptr;
  }
  server::RemoteSettings& settings = *read;
  server::RemoteEnvironmentOptions options;
  options.configurationJson = std::move(settings.configurationJson);
  options.isAbsenceTolerated = settings.policy.isTolerant;
  options.keepsState = making.remote.keepsState;
  options.stepTimeout = timeOfStep(making, settings.stepTimeout, options.stepTimeout);
  auto connected = server::connectRemoteEnvironment(address, options);
  if (!connected) {
    printError(connected.error());
    return nullptr;
  }
  return settings.policy.around(
      std::move(*connected),
      [sink = making.onFailure](std::uint64_t step, const std::string& message) { (*sink)(step, message); });
}

Process loadPlugin(const std::string& library, const std::string& entryJson, const std::string& what,
                   const Making& making) {
  if (!mayStart(library, making)) {
    return nullptr;
  }
  auto read = readSettings(entryJson, what, making);
  if (!read) {
    return nullptr;
  }
  server::RemoteSettings& settings = *read;
  auto loaded =
      server::loadPluginProcess(library, entryJson, timeOfStep(making, settings.stepTimeout, std::chrono::seconds(60)));
  if (!loaded) {
    printError(loaded.error());
    return nullptr;
  }
  return settings.policy.around(
      std::move(*loaded),
      [sink = making.onFailure](std::uint64_t step, const std::string& message) { (*sink)(step, message); });
}

constexpr unsigned kMostLightThreads = 256;  // the bound of the key `threads`

// the configuration of a built-in process with the threads of the command line, unless it says how many
std::string withThreads(const std::string& name, const std::string& configurationJson, unsigned threads) {
  const environment::ProcessEntry* const entry = environment::findProcess(name);
  const bool hasKey = entry != nullptr && std::any_of(entry->keys.begin(), entry->keys.end(),
                                                      [](const auto& key) { return key.name == "threads"; });
  nlohmann::json configuration =
      nlohmann::json::parse(configurationJson.empty() ? "{}" : configurationJson, nullptr, false);
  if (!hasKey || !configuration.is_object() || configuration.contains("threads")) {
    return configurationJson;
  }
  configuration["threads"] = std::clamp(threads, 1U, kMostLightThreads);
  return configuration.dump();
}

// a built-in process; with a time limit it is supervised and made again after a time-out
Process makeBuiltIn(const std::string& name, const std::string& entryJson, const FilePart& part, const Making& making) {
  const std::string configurationJson = withThreads(name, entryJson, making.remote.threads);
  Process made = orPrintErrors(environment::makeProcess(name, configurationJson), part);
  if (!made) {
    return made;
  }
  std::vector<core::Diagnostic> warnings = environment::idleKeys(name, configurationJson);
  for (core::Diagnostic& warning : warnings) {
    warning.message = part.placed(warning.message);
  }
  if (!printDiagnostics(std::move(warnings), making.isQuiet, making.remote.isStrict)) {
    return nullptr;
  }
  if (making.remote.timeoutSeconds == 0.0) {
    return made;
  }
  const auto again = [name, configurationJson]() -> Process {
    auto fresh = environment::makeProcess(name, configurationJson);
    return fresh ? std::move(*fresh) : nullptr;
  };
  return server::supervised(
      std::move(made), {.stepTimeout = timeOfStep(making, std::nullopt, std::chrono::seconds(60)), .again = again});
}

// one entry of a configuration: `tcp` with an `address` and `stdio` with a `command` are other processes
Process makeEntry(const environment::EnvironmentEntry& entry, const FilePart& part, const Making& making) {
  const std::string what = "the environment '" + entry.name + "'";
  if (entry.type == "offered" || entry.type == "gallery" || entry.type == "field") {
    printError(part.placed(what + " " +
                           (entry.type == "offered" ? "is offered to a server" : "is an environment file on a server") +
                           ": give another one, such as tcp://HOST:PORT or a file"));
    return nullptr;
  }
  if (entry.type == "plugin") {
    const auto library = protocol::memberOf(entry.configuration, "library");
    if (!library) {
      printError(part.placed(what + " needs a member 'library': the file of the plug-in"));
      return nullptr;
    }
    return loadPlugin(*library, entry.configuration, part.name + ": " + what + ": ", making);
  }
  if (entry.type != "tcp" && entry.type != "stdio") {
    return makeBuiltIn(entry.type, entry.configuration, part, making);
  }
  const bool isTcp = entry.type == "tcp";
  const std::string key = isTcp ? "address" : "command";
  const std::string target = protocol::memberOf(entry.configuration, key).value_or("");
  if (target.empty()) {
    printError(
        part.placed(what + " needs a member '" + key + "': " + (isTcp ? "HOST:PORT" : "the command that starts it")));
    return nullptr;
  }
  const bool isWhole = isTcp && (startsWith(target, "tcp://") || startsWith(target, "unix:"));
  const std::string scheme = isWhole ? "" : isTcp ? "tcp://" : "stdio:";
  return connectRemote(scheme + target, entry.configuration, part.name + ": " + what + ": ", making);
}

// a single process, or a set of processes that queries address by name
Process loadConfiguration(const std::string& file, core::FileProvider& files, std::vector<std::string>& names,
                          const Making& making) {
  const std::optional<std::string> json = files.read(file);
  if (!json) {
    printError("there is no environment file '" + file + "': check the name and the working folder");
    return nullptr;
  }
  const std::string text = files::asUtf8(*json);
  auto parsed = environment::parseEnvironmentEntries(text);
  if (!parsed) {
    for (core::Diagnostic& error : parsed.error()) {
      if (!error.location.file.empty()) {
        // a place in the text is a place in this file
        error.location.file = file;
        continue;
      }
      // "environment[1] has no 'type'"
      const bool isOfList = error.message.starts_with("environment[");
      const std::size_t open = error.message.find('[');
      const std::string path =
          isOfList ? error.message.substr(open, error.message.find(']') + 1 - open) : std::string();
      error.message = FilePart{file, text, path}.placed(error.message);
    }
    return orPrintErrors(tl::unexpected(std::move(parsed.error())), {});
  }
  std::vector<environment::EnvironmentEntry>& entries = *parsed;
  for (environment::EnvironmentEntry& entry : entries) {
    auto problem = server::embedAllFiles(entry, file, files);
    if (problem) {
      printDiagnostics(std::vector{*problem}, false);
      return nullptr;
    }
  }
  if (entries.empty()) {
    printError("'" + file +
               "' lists no environment: add an object such as {\"type\":\"height\"}, or leave out the file");
    return nullptr;
  }
  std::vector<std::pair<std::string, Process>> processes;
  const bool isList = jsonPlace(text, "[0]") != jsonPlace(text, "");
  for (const environment::EnvironmentEntry& entry : entries) {
    const std::string path = isList ? "[" + std::to_string(&entry - entries.data()) + "]" : std::string();
    Process process = makeEntry(entry, {file, text, path}, making);
    if (!process) {
      return nullptr;
    }
    if (entries.size() > 1) {
      names.push_back(entry.name);
    }
    // a single environment answers all queries, of any name
    processes.emplace_back(entries.size() == 1 ? std::string{} : entry.name, std::move(process));
  }
  return environment::makeEnvironmentSet(std::move(processes));
}

/// How an environment file (.e) may start the program that it names.
struct FolderProgram {
  environment::EnvironmentFile field;
  bool isThere = false;     // it can be started
  bool isBuiltIn = false;   // there is a process of that name
  bool isInFolder = false;  // the folder of the file brings it
};

FolderProgram folderProgramOf(const std::string& file, core::FileProvider& files) {
  std::vector<core::Diagnostic> unused;
  FolderProgram program;
  program.field = environment::readEnvironmentFile(file, files.read(file).value_or(std::string()), unused, unused);
  if (!program.field.command.empty()) {
    const std::string& name = program.field.command.front();
    const std::string folder = std::filesystem::path(file).parent_path().string();
    program.isInFolder = server::isProgramIn(name, folder);
    program.isThere = !server::findExecutable(name, folder).empty();
    program.isBuiltIn = !environment::configurationSchema(program.field.program).empty();
  }
  return program;
}

Process startFolderProgram(const std::string& file, const FolderProgram& program, bool isQuiet,
                           core::FileProvider& files, const RemoteOptions& options) {
  std::vector<core::Diagnostic> warnings;
  server::LegacyProcessOptions legacy;
  if (options.timeoutSeconds > 0.0) {
    legacy.stepTimeout = std::chrono::milliseconds(static_cast<std::int64_t>(options.timeoutSeconds * 1e3));
  }
  Process made = orPrintErrors(server::makeLegacyProcess(file, files, legacy, warnings), {});
  if (!printDiagnostics(std::move(warnings), isQuiet, options.isStrict)) {
    return nullptr;
  }
  if (made && !isQuiet) {
    printNote("starting the program '" + program.field.command.front() + "' that " + file + " names");
  }
  return made;
}

Process loadFieldFile(const std::string& file, core::Compatibility compatibility, bool isQuiet,
                      core::FileProvider& files, const Making& making) {
  const RemoteOptions& options = making.remote;
  if (!files.read(file)) {
    printError("there is no environment file '" + file + "': check the name and the working folder");
    return nullptr;
  }
  const FolderProgram program = folderProgramOf(file, files);
  if (options.allowsFolderPrograms && (program.isInFolder || (program.isThere && !program.isBuiltIn))) {
    if (!mayStart(program.field.command.front(), making)) {
      return nullptr;
    }
    return startFolderProgram(file, program, isQuiet, files, options);
  }
  if (program.isThere && !program.isBuiltIn) {
    printDiagnostics(std::vector{core::Diagnostic{
                         core::Severity::Error,
                         "the environment file names a program that is not built in: '" + program.field.program + "'",
                         program.field.executable,
                         "--allow-folder-programs starts it, for folders that you trust; a server never does"}},
                     false);
    return nullptr;
  }
  std::vector<core::Diagnostic> warnings;
  environment::ProcessOrErrors made = environment::makeFromEnvironmentFile(file, files, compatibility, warnings);
  if (!printDiagnostics(std::move(warnings), isQuiet, options.isStrict)) {
    return nullptr;
  }
  return orPrintErrors(std::move(made), {});
}

Process makeEnvironment(const std::string& name, core::Compatibility compatibility, bool isQuiet,
                        core::FileProvider& files, std::vector<std::string>& names, const Making& making) {
  if (startsWith(name, "tcp://") || startsWith(name, "unix:") || startsWith(name, "stdio:")) {
    return connectRemote(name, "{}", "--environment-", making);
  }
  if (startsWith(name, "{") || startsWith(name, "[")) {
    printError("--environment takes the name of a file, not JSON text: write the text into a file such as light.json");
    return nullptr;
  }
  const std::string suffix = std::filesystem::path(name).extension().string();
  if (suffix == ".json") {
    return loadConfiguration(name, files, names, making);
  }
  if (isPluginFile(name)) {
    return loadPlugin(name, "{}", "--environment-", making);
  }
  if (suffix == ".e") {
    return loadFieldFile(name, compatibility, isQuiet, files, making);
  }
  if (const std::string problem = problemOfScriptName(name); !problem.empty()) {
    printError(problem);
    return nullptr;
  }
  // a model folder may give its environment file any name; no built-in process has a name like a path
  if (name.find_first_of("./") != std::string::npos && files.read(name)) {
    return loadFieldFile(name, compatibility, isQuiet, files, making);
  }
  if (startsWith(name, "offered:")) {
    printError(
        "'" + name +
        "' is offered to a server, which `espalier connect` asks: write tcp://HOST:PORT, unix:PATH or stdio:COMMAND");
    return nullptr;
  }
  if (name.find(':') != std::string::npos) {
    printError("'" + name + "' is no address of an environment: write tcp://HOST:PORT, unix:PATH or stdio:COMMAND");
    return nullptr;
  }
  return makeBuiltIn(name, "", {}, making);
}

}  // namespace

bool isPluginFile(const std::string& name) {
  const std::string file = std::filesystem::path(name).filename().string();
  return file.ends_with(".so") || file.find(".so.") != std::string::npos;
}

std::string problemOfScriptName(const std::string& name) {
  std::error_code error;
  const bool isCommand = name.find(' ') != std::string::npos && !std::filesystem::exists(name, error);
  const bool isPython = name.ends_with(".py");
  if (!isCommand && !isPython && !name.ends_with(".R")) {
    return {};
  }
  const std::string starter = isCommand ? "" : isPython ? "python3 " : "Rscript ";
  return "'" + name + "' is a program, not the name of an environment: write --environment 'stdio:" + starter + name +
         "', which starts it";
}

server::FailureSink failureNotes(bool isQuiet) {
  return [isQuiet](std::uint64_t step, const std::string& message) {
    if (!isQuiet) {
      printNote("step " + std::to_string(step) + ": " + message);
    }
  };
}

std::optional<LoadedEnvironment> loadEnvironment(const std::string& name, core::Compatibility compatibility,
                                                 bool isQuiet, core::FileProvider& files, const RemoteOptions& remote) {
  core::RecordingFileProvider recorder(files);
  LoadedEnvironment loaded;
  loaded.onFailure = std::make_shared<server::FailureSink>(failureNotes(isQuiet));
  loaded.process =
      makeEnvironment(name, compatibility, isQuiet, recorder, loaded.processNames, {remote, loaded.onFailure, isQuiet});
  if (!loaded.process) {
    return std::nullopt;
  }
  loaded.origin = {name, recorder.take()};
  return loaded;
}

bool warnAboutUnansweredQueries(const language::Program& program, const LoadedEnvironment* environment, bool isQuiet,
                                bool isStrict) {
  if (environment != nullptr && environment->processNames.empty()) {
    return true;
  }
  const std::vector<std::string> names =
      environment == nullptr ? std::vector<std::string>{} : environment->processNames;
  return printDiagnostics(language::unansweredQueries(program, names), isQuiet, isStrict);
}

bool warnAboutUnaskedEnvironment(const language::Program& program, bool isQuiet, bool isStrict) {
  const std::optional<core::Diagnostic> warning = language::unaskedEnvironment(program);
  return !warning || printDiagnostics({*warning}, isQuiet, isStrict);
}

}  // namespace espalier::command
