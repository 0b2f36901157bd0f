#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "clients/cpp/client.h"
#include "clients/espalier/client_token.h"
#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/result.h"
#include "clients/espalier/server_connection.h"
#include "clients/espalier/sweep/swept_environment.h"
#include "clients/espalier/world_file.h"
#include "engine/files/utf8.h"
#include "engine/language/compiler.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/model_files.h"
#include "server/remote/translation/translate.h"

namespace espalier::command {
namespace {

using client::Client;
using client::Outcome;

struct ConnectOptions {
  ServerAddress server;
  std::string token;
  std::string model;
  std::string gallery;
  std::string environment;
  std::string compatibility;
  std::string world;
  std::string stepDuration;
  std::string simulation;
  std::string what = "string";
  std::string file;
  std::vector<std::string> symbols;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint64_t> until;
  std::optional<std::uint64_t> derivationLength;
  std::uint64_t steps = 1;
  std::uint64_t frames = 0;
  std::uint64_t every = 1;
  std::uint32_t plant = 0;
  std::function<int(Client&, const ConnectOptions&)> run;
};

int fail(const protocol::Error& error) {
  printError(error.message);
  return kFailure;
}

void printLine(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fputc('\n', stdout);
  std::fflush(stdout);
}

/// Sends a request and prints the result, or one member of it, as a line.
int ask(Client& client, std::string_view method, const std::string& params, std::string_view member = {}) {
  const Outcome outcome = client.request(method, params);
  if (!outcome) {
    return fail(outcome.error());
  }
  const auto& result = *outcome;
  printLine(member.empty() ? result : protocol::memberOf(result, member).value_or(result));
  return kSuccess;
}

std::string simulationParams(const ConnectOptions& options) {
  protocol::JsonWriter params;
  return params.beginObject().key("simulation").text(options.simulation).endObject().take();
}

// a file as the model folder on the server names it
std::string nameInFolder(const std::string& file, const std::filesystem::path& folder) {
  const std::filesystem::path inside = std::filesystem::path(file).lexically_relative(folder);
  return inside.empty() || *inside.begin() == ".." ? file : inside.string();
}

void writeObject(protocol::JsonWriter& params, const char* key, const std::map<std::string, std::string>& texts) {
  params.key(key).beginObject();
  for (const auto& [name, text] : texts) {
    params.key(name).text(text);
  }
  params.endObject();
}

/// The model with its files: the text files of its folder with a known suffix, its colours, and every other file that
/// it reads.
void writeModelFiles(protocol::JsonWriter& params, const server::ModelFiles& model) {
  namespace fs = std::filesystem;
  constexpr std::array<std::string_view, 14> kSuffixes{".l",   ".v",    ".h", ".s", ".func", ".funcs", ".fset",
                                                       ".con", ".cset", ".a", ".t", ".crv",  ".map",   ".mat"};
  server::DiskFileProvider files(16'000'000);
  const fs::path main(model.model);
  const fs::path folder = main.has_parent_path() ? main.parent_path() : fs::path(".");
  std::map<std::string, std::string> contents;  // by name in the folder
  std::error_code error;
  bool hasSpecifications = false;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const fs::path& name = entry.path();
    const bool isSpecifications = model.isFolder && name.filename() == "specifications";
    if (isSpecifications ||
        std::find(kSuffixes.begin(), kSuffixes.end(), name.extension().string()) != kSuffixes.end()) {
      if (auto text = files.read(name.string())) {
        contents.emplace(name.filename().string(), std::move(*text));
        hasSpecifications = hasSpecifications || isSpecifications;
      }
    }
  }
  // files that the model reads may have any suffix; the server reports the errors of a model that does not compile
  language::CompileInput input;
  input.modelFile = model.model;
  input.viewFile = model.view;
  if (const auto program = language::compile(input, files).program) {
    for (const auto& source : program->sources) {
      contents.emplace(nameInFolder(source.name, folder), source.text);
    }
    for (const language::ModelFile& file : program->files) {
      if (file.source != language::ModelFile::kNoSource) {
        contents.emplace(file.name, program->sources[file.source].text);
      }
    }
  }
  std::map<std::string, std::string> texts;
  std::map<std::string, std::string> bytes;
  for (auto& [name, content] : contents) {
    const bool isText = files::asUtf8(content) == content && content.find('\0') == std::string::npos;
    (isText ? texts : bytes).emplace(name, isText ? content : protocol::toBase64(content));
  }
  writeObject(params, "files", texts);
  if (!bytes.empty()) {
    writeObject(params, "binaryFiles", bytes);
  }
  if (!hasSpecifications) {
    params.key("main").text(main.filename().string());
  }
}

/// The text of a configuration as an array in one line, for the wire.
Result<std::string> arrayOf(std::string json) {
  if (const auto fault = protocol::jsonProblem(json)) {
    return problem("the environment is not JSON: " + *fault);
  }
  // newlines between JSON tokens mean nothing
  std::replace(json.begin(), json.end(), '\n', ' ');
  std::replace(json.begin(), json.end(), '\r', ' ');
  const std::size_t first = json.find_first_not_of(" \t");
  const bool isArray = first != std::string::npos && json[first] == '[';
  return isArray ? json : "[" + json + "]";
}

/// A configuration file (.json) as an array. The files that it names are in it: the server need not have them.
Result<std::string> configurationArray(const std::string& file) {
  server::DiskFileProvider files;
  const auto text = files.read(file);
  if (!text) {
    return problem("the environment file '" + file + "' cannot be read");
  }
  const auto whole = readConfiguration(*text, file, files);
  if (!whole) {
    return problem(whole.error());
  }
  return arrayOf(whole->empty() ? *text : *whole);
}

/// `NAME`, `tcp://HOST:PORT`, `offered:NAME`, `stdio:COMMAND`, a JSON text or a .json file, as the environment array.
Result<std::string> environmentArray(const std::string& text) {
  const auto entryOf = [](std::string_view type, std::string_view key = {}, std::string_view value = {}) {
    protocol::JsonWriter array;
    array.beginArray().beginObject().key("type").text(type);
    if (!key.empty()) {
      array.key(key).text(value);
    }
    return array.endObject().endArray().take();
  };
  if (text.starts_with("tcp://")) {
    return entryOf("tcp", "address", text.substr(6));
  }
  if (text.starts_with("offered:")) {
    return entryOf("offered", "name", text.substr(8));
  }
  if (text.starts_with("stdio:")) {
    return entryOf("stdio", "command", text.substr(6));
  }
  if (text.ends_with(".json")) {
    return configurationArray(text);
  }
  if (text.find_first_of("[{") == std::string::npos) {
    if (std::string sentence = problemOfScriptName(text); !sentence.empty()) {
      return problem(std::move(sentence));
    }
    return entryOf(text);
  }
  return arrayOf(text);
}

/// The published environment file (.e) beside a model with the files that it names, as the environment array.
Result<std::string> publishedFileArray(const std::string& file, const std::string& compatibility) {
  server::DiskFileProvider files(16'000'000);
  const auto loaded = loadEnvironment(file, server::toCompatibility(compatibility), false, files);
  if (!loaded) {
    return problem("the environment file '" + file + "' cannot be used: see above");
  }
  // names relative to the folder of the file: the server need not know the folder
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  const auto nameIn = [&](const std::string& name) {
    return std::filesystem::path(name).lexically_relative(folder).generic_string();
  };
  protocol::JsonWriter array;
  array.beginArray().beginObject().key("type").text("field").key("main").text(nameIn(file)).key("files").beginObject();
  std::set<std::string> names;
  for (const auto& [name, text] : loaded->origin.files) {
    if (names.insert(name).second) {
      array.key(nameIn(name)).text(text);
    }
  }
  return array.endObject().endObject().endArray().take();
}

int create(Client& client, const ConnectOptions& options) {
  if (options.model.empty() == options.gallery.empty()) {
    printError("give either a MODEL (a .l file or a folder) or --gallery NAME");
    return kUsage;
  }
  protocol::JsonWriter params;
  std::string environmentFile;
  params.beginObject().key("model").beginObject();
  if (!options.gallery.empty()) {
    params.key("gallery").text(options.gallery);
  } else {
    const server::FoundModel found = server::findModelFiles(options.model);
    if (!found) {
      // a name without folder and suffix
      const bool mayBeOfGallery = options.model.find_first_of("/.") == std::string::npos;
      printError(found.error() + (found.error().ends_with('?') || !mayBeOfGallery ? "" : ".") +
                 (mayBeOfGallery ? " --gallery NAME takes a model of the server's gallery" : ""));
      return kFailure;
    }
    printDiagnostics(found->remarks, false);
    writeModelFiles(params, *found);
    environmentFile = found->environment;
  }
  params.endObject();
  if (!options.environment.empty()) {
    const auto array = environmentArray(options.environment);
    if (!array) {
      printError(array.error());
      return kUsage;
    }
    params.key("environment").raw(*array);
  } else if (!environmentFile.empty()) {
    const auto array = environmentFile.ends_with(".json") ? configurationArray(environmentFile)
                                                          : publishedFileArray(environmentFile, options.compatibility);
    if (!array) {
      printError(array.error());
      return kFailure;
    }
    params.key("environment").raw(*array);
  }
  ModelOptions of;
  of.model = options.model;
  of.world = options.world;
  of.stepDuration = options.stepDuration;
  if (const std::string worldFile = worldFileOf(of); hasWorld(of, worldFile)) {
    server::DiskFileProvider files;
    const auto world = readWorld(of, worldFile, files);
    if (!world) {
      return kFailure;
    }
    protocol::write(params, *world);
  }
  if (options.seed) {
    params.key("seed").integer(*options.seed);
  }
  if (options.derivationLength) {
    params.key("derivationLength").integer(*options.derivationLength);
  }
  if (!options.compatibility.empty()) {
    params.key("compatibility").text(options.compatibility);
  }
  const Outcome outcome = client.request("simulation.create", params.endObject().view());
  if (!outcome) {
    return fail(outcome.error());
  }
  const auto& result = *outcome;
  printNote("seed " + protocol::memberOf(result, "seed").value_or("?"));
  printLine(protocol::memberOf(result, "simulation").value_or(result));
  return kSuccess;
}

int step(Client& client, const ConnectOptions& options) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(options.simulation);
  if (options.until) {
    params.key("until").integer(*options.until);
  } else {
    params.key("steps").integer(options.steps);
  }
  return ask(client, "simulation.step", params.endObject().take());
}

int get(Client& client, const ConnectOptions& options) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(options.simulation).key("what").text(options.what);
  params.key("plant").integer(options.plant).endObject();
  return ask(client, "simulation.get", params.take(), options.what == "string" ? "string" : "");
}

int reset(Client& client, const ConnectOptions& options) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(options.simulation);
  if (options.seed) {
    params.key("seed").integer(*options.seed);
  }
  return ask(client, "simulation.reset", params.endObject().take());
}

int stream(Client& client, const ConnectOptions& options) {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(options.simulation).key("what").text(options.what);
  params.key("every").integer(options.every);
  if (!options.symbols.empty()) {
    params.key("select").beginObject().key("symbols").texts(options.symbols).endObject();
  }
  const Outcome outcome = client.request("stream.open", params.endObject().view());
  if (!outcome) {
    return fail(outcome.error());
  }
  std::uint64_t received = 0;
  while (options.frames == 0 || received < options.frames) {
    const auto notification = client.nextNotification(std::chrono::hours(24));
    if (!notification) {
      printError("the server closed the connection");
      return kFailure;
    }
    if (notification->method == "stream.end") {
      printNote(protocol::memberOf(notification->paramsJson, "reason").value_or("the server closed the stream"));
      return kFailure;
    }
    if (notification->method != "stream.data") {
      continue;
    }
    printLine(notification->paramsJson);
    ++received;
    if (options.frames == 0 && protocol::memberOf(notification->paramsJson, "finished") == "true") {
      return kSuccess;
    }
  }
  return kSuccess;
}

int save(Client& client, const ConnectOptions& options) {
  const Outcome outcome = client.request("simulation.save", simulationParams(options));
  if (!outcome) {
    return fail(outcome.error());
  }
  const auto snapshot = protocol::memberOf(*outcome, "snapshot");
  const auto bytes = snapshot ? protocol::fromBase64(*snapshot) : std::nullopt;
  if (!bytes) {
    printError("the server's answer has no snapshot");
    return kFailure;
  }
  if (const auto problem = server::writeFileAtomically(options.file, *bytes)) {
    printError(*problem);
    return kFailure;
  }
  printNote("saved " + options.file);
  return kSuccess;
}

int restore(Client& client, const ConnectOptions& options) {
  const auto bytes = server::DiskFileProvider(SIZE_MAX).read(options.file);
  if (!bytes) {
    printError("the snapshot '" + options.file + "' cannot be read");
    return kFailure;
  }
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(options.simulation);
  params.key("snapshot").text(protocol::toBase64(*bytes)).endObject();
  return ask(client, "simulation.restore", params.take());
}

int runConnect(const ConnectOptions& options) {
  client::ClientOptions clientOptions;
  clientOptions.name = "espalier connect";
  clientOptions.token = options.token;
  clientOptions.requestTimeout = std::chrono::hours(24);
  const auto connection = connectTo(options.server, clientOptions);
  if (!connection) {
    printError(connection.error());
    return kFailure;
  }
  return options.run(*connection->client, options);
}

using Run = std::function<int(Client&, const ConnectOptions&)>;

CLI::App* addAction(CLI::App& command, const std::shared_ptr<ConnectOptions>& options, const std::string& name,
                    const std::string& help, Run run) {
  CLI::App* action = command.add_subcommand(name, help);
  action->callback([options, run = std::move(run)] { options->run = run; });
  return action;
}

void addSimulation(CLI::App* action, const std::shared_ptr<ConnectOptions>& options) {
  action->add_option("SIMULATION", options->simulation, "Identifier that `create` printed")->required();
}

Run asking(std::string method) {
  return [method = std::move(method)](Client& client, const ConnectOptions& options) {
    return ask(client, method, options.simulation.empty() ? "{}" : simulationParams(options));
  };
}

}  // namespace

void addConnect(CLI::App& program, int& status) {
  const auto options = std::make_shared<ConnectOptions>();
  CLI::App* command = program.add_subcommand("connect", "Use a running server from the shell");
  command->footer(
      "Each result is one line on standard output: an identifier, a string, or JSON (try `| jq`).\nExamples:\n"
      "  plant=$(espalier connect 127.0.0.1:4321 create MODEL.l --environment honda --seed 7)\n"
      "  espalier connect 127.0.0.1:4321 step $plant 3\n"
      "  espalier connect 127.0.0.1:4321 get $plant string\n"
      "`espalier connect HOST:PORT ACTION --help` explains an action.");
  addServerAddress(*command, options->server, true);
  addClientToken(*command, options->token);
  command->require_subcommand(1);

  CLI::App* action = addAction(*command, options, "create", "Create a simulation; prints its identifier", create);
  action->add_option("MODEL", options->model, "A .l file or its folder; its data files are sent too");
  action->add_option("--gallery", options->gallery, "Name of a model in the gallery of the server, instead of MODEL");
  action->add_option(
      "--environment", options->environment,
      "NAME, tcp://HOST:PORT, offered:NAME, 'stdio:COMMAND', JSON, or a .json file (default: the .e file "
      "beside the model, if it exists)");
  action->add_option("--seed", options->seed,
                     "Seed of the random numbers (default: the server draws one and prints it)");
  action->add_option("--derivation-length", options->derivationLength, "Number of steps instead of the model's");
  action->add_option("--compat", options->compatibility,
                     "Reproduce the program cpfg: its interactive run (cpfg) or its batch run (cpfg-batch)");
  addWorldOptions(*action, options->world, options->stepDuration);

  action = addAction(*command, options, "step", "Make steps; prints the completed step", step);
  addSimulation(action, options);
  action->add_option("STEPS", options->steps, "Number of steps")->capture_default_str();
  action->add_option("--until", options->until, "Continue to this step, instead of STEPS");

  action = addAction(*command, options, "run", "Make all remaining steps", asking("simulation.run"));
  addSimulation(action, options);

  action = addAction(*command, options, "get", "Print one part of the state of a simulation", get);
  addSimulation(action, options);
  action
      ->add_option("WHAT", options->what,
                   "A value of `what` in simulation.get, as string, statistics, state-hash, turtle, model, "
                   "information, environment or productions")
      ->capture_default_str();
  action->add_option("--plant", options->plant, "Number of the plant, from 0")->capture_default_str();

  action =
      addAction(*command, options, "stream", "Print a frame after each step, until the simulation is finished", stream);
  addSimulation(action, options);
  action->add_option("WHAT", options->what, "turtle, string or statistics")->capture_default_str();
  action->add_option("--every", options->every, "Only steps that are multiples of this")->capture_default_str();
  action->add_option("--frames", options->frames, "Stop after N frames");
  action->add_option("--symbol", options->symbols, "Only turtle records of this symbol. May be repeated");

  action = addAction(*command, options, "reset", "Go back to step 0", reset);
  addSimulation(action, options);
  action->add_option("--seed", options->seed, "The new seed");

  action = addAction(*command, options, "save", "Save a snapshot to a file", save);
  addSimulation(action, options);
  action->add_option("FILE", options->file, "File to write")->required();

  action = addAction(*command, options, "restore", "Restore the state of a snapshot", restore);
  addSimulation(action, options);
  action->add_option("FILE", options->file, "File that `save` wrote")->required();

  action =
      addAction(*command, options, "delete", "Delete a simulation and its saved state", asking("simulation.delete"));
  addSimulation(action, options);

  addAction(*command, options, "list", "Print all simulations of the server", asking("simulation.list"));
  addAction(*command, options, "status", "Print the load and the contents of the server", asking("server.status"));
  addAction(*command, options, "environments",
            "Print the built-in environments with their schemas, and the offered ones", asking("environment.list"));

  command->callback([options, &status] { status = runConnect(*options); });
}

}  // namespace espalier::command
