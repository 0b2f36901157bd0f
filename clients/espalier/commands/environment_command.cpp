#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/conformance/program_output.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/environment_words.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/output/field_writing_process.h"
#include "environment/environment_entries.h"
#include "environment/registry.h"
#include "protocol/codec.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/disk_files.h"
#include "server/remote/hosting/environment_check.h"
#include "server/remote/hosting/environment_host.h"
#include "server/remote/processes/legacy_process.h"
#include "server/remote/processes/line_channel.h"
#include "server/remote/processes/plugin_library.h"
#include "server/remote/terrain/terrain_embedding.h"
#include "server/remote/trace_file.h"
#include "server/remote/translation/translate.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

// the NAME that runs an existing environment program with the published pipe protocol
constexpr const char* kLegacy = "legacy";
// the NAME that runs a plug-in
constexpr const char* kPlugin = "plugin";

struct EnvironmentOptions {
  std::string name;
  std::string address;
  std::string configurationFile;
  std::string executable;
  std::string fieldFile;
  std::string library;
  double timeLimitSeconds = 60.0;
  bool isOnStdio = false;
  bool isInsecureAllowed = false;
  bool describes = false;
  bool isJson = false;
  bool printsSchema = false;
  bool lists = false;
  bool writesEveryStep = false;
  FieldOutputs fields;
};

int listProcesses() {
  for (const std::string& name : environment::processNames()) {
    const auto process = environment::makeProcess(name, "");
    const std::string summary = process ? (*process)->describe().summary : std::string();
    std::printf("%-12s %s\n", name.c_str(), summary.c_str());
  }
  return kSuccess;
}

/// The process that the options ask for. Every simulation gets a new one.
environment::ProcessOrErrors makeAsked(const EnvironmentOptions& options, const std::string& configuration,
                                       std::vector<core::Diagnostic>& warnings) {
  if (options.name == kPlugin) {
    auto loaded = server::loadPluginProcess(options.library, configuration);
    if (!loaded) {
      return tl::unexpected(std::vector{core::Diagnostic{core::Severity::Error, std::move(loaded.error()), {}, {}}});
    }
    return std::move(*loaded);
  }
  if (options.name != kLegacy) {
    return environment::makeProcess(options.name, configuration);
  }
  server::DiskFileProvider files;
  server::LegacyProcessOptions legacy;
  legacy.executable = options.executable;
  legacy.stepTimeout = std::chrono::milliseconds(static_cast<std::int64_t>(options.timeLimitSeconds * 1000.0));
  return server::makeLegacyProcess(options.fieldFile, files, legacy, warnings);
}

int serveOn(const std::string& address, bool isInsecureAllowed, const server::ProcessFactory& factory) {
  server::HostAddress where{.isInsecureAllowed = isInsecureAllowed};
  if (!server::splitAddress(address, where.host, where.port)) {
    printError("'" + address + "' is not an address: write HOST:PORT, for example 127.0.0.1:4000");
    return kUsage;
  }
  const std::string shownHost = address.substr(0, address.rfind(':'));
  const auto problem = server::hostEnvironment(where, factory, [&](std::uint16_t boundPort) {
    std::printf("listening on %s:%u\n", shownHost.c_str(), static_cast<unsigned>(boundPort));
    std::fflush(stdout);
  });
  if (problem) {
    printError(*problem);
    return kFailure;
  }
  return kSuccess;
}

// The configuration of one process from the text of a file. The file may also be one for `--environment`: an object
// with a `type`. Prints the errors and returns nothing when the text is wrong.
std::optional<std::string> configurationOf(const EnvironmentOptions& options, const std::string& text) {
  if (!protocol::memberOf(text, "type")) {
    return text;
  }
  auto parsed = environment::parseEnvironmentEntries(text);
  if (!parsed) {
    printDiagnostics(parsed.error(), false);
    return std::nullopt;
  }
  const environment::EnvironmentEntry& entry = parsed->front();
  if (environment::canonicalName(entry.type) != environment::canonicalName(options.name)) {
    printError("the configuration file '" + options.configurationFile + "' is for '" + entry.type + "', not for '" +
               options.name + "': name that environment, or another file");
    return std::nullopt;
  }
  return entry.configuration;
}

// the description that a peer gets, with the aliases, the source and the configuration schema for people
std::string contractOf(const std::string& name, const turtle::EnvironmentProcess& process) {
  std::string described = protocol::encode(server::toDescribeResult(process.describe()));
  const std::string schema = environment::configurationSchema(name);
  if (schema.empty()) {
    return described;
  }
  protocol::JsonWriter more;
  more.beginObject().key("aliases").texts(environment::aliasesOf(name));
  more.key("source").text(environment::sourceOf(name)).key("configuration").raw(schema).endObject();
  described.back() = ',';
  return described + more.take().substr(1);
}

int runEnvironment(EnvironmentOptions& options) {
  if (options.lists) {
    return listProcesses();
  }
  if (!options.fields.parse()) {
    return kUsage;
  }
  const int modes = (options.address.empty() ? 0 : 1) + (options.isOnStdio ? 1 : 0) + (options.describes ? 1 : 0) +
                    (options.printsSchema ? 1 : 0);
  if (options.name.empty() || modes != 1) {
    printError(
        "give the NAME of a built-in environment and one of --listen HOST:PORT, --stdio, --describe and --schema; "
        "--list names them");
    return kUsage;
  }
  std::string configuration;
  if (!options.configurationFile.empty()) {
    auto text = server::DiskFileProvider().read(options.configurationFile);
    if (!text) {
      printError("the configuration file '" + options.configurationFile + "' cannot be read");
      return kFailure;
    }
    auto chosen = configurationOf(options, *text);
    if (!chosen) {
      return kFailure;
    }
    configuration = std::move(*chosen);
    // put the files that the configuration names into it
    environment::EnvironmentEntry entry{options.name, options.name, configuration};
    server::DiskFileProvider files;
    auto problem = server::embedAllFiles(entry, options.configurationFile, files);
    if (problem) {
      printDiagnostics(std::vector{*problem}, false);
      return kFailure;
    }
    configuration = std::move(entry.configuration);
  }

  if ((options.name == kLegacy) == options.fieldFile.empty() ||
      (options.name != kLegacy && !options.executable.empty())) {
    printError(options.name == kLegacy ? "give the environment file of the program with --spec FILE.e"
                                       : "--executable and --spec are for the environment 'legacy'");
    return kUsage;
  }
  if ((options.name == kPlugin) == options.library.empty()) {
    printError(options.name == kPlugin ? "give the file of the plug-in with --library FILE.so"
                                       : "--library is for the environment 'plugin'");
    return kUsage;
  }
  // make the process once here, so that errors appear before a peer connects
  std::vector<core::Diagnostic> warnings;
  auto made = makeAsked(options, configuration, warnings);
  printDiagnostics(warnings, false);
  if (!made) {
    // a place in the configuration is a place in its file
    for (core::Diagnostic& problem : made.error()) {
      if (!options.configurationFile.empty() && problem.location.file == "configuration") {
        problem.location.file = options.configurationFile;
      } else if (!options.configurationFile.empty() && problem.location.file.empty()) {
        problem.message = options.configurationFile + ": " + problem.message;
      }
    }
    printDiagnostics(made.error(), false);
    return kFailure;
  }
  if (options.printsSchema) {
    std::printf("%s\n", environment::configurationSchema(options.name).c_str());
    return kSuccess;
  }
  if (options.describes) {
    const std::string contract = contractOf(options.name, **made);
    std::printf("%s", options.isJson ? (contract + "\n").c_str() : environmentInWords(contract).c_str());
    return kSuccess;
  }
  const server::ProcessFactory factory = [&options, &configuration] {
    std::vector<core::Diagnostic> said;  // printed already
    auto fresh = makeAsked(options, configuration, said);
    return options.fields.isEmpty() ? std::move(fresh.value())
                                    : writingFields(std::move(fresh.value()), options.fields, options.writesEveryStep);
  };
  if (options.isOnStdio) {
    if (const auto problem = server::hostEnvironmentOnStdio(factory)) {
      printError(*problem);
      return kFailure;
    }
    return kSuccess;
  }
  return serveOn(options.address, options.isInsecureAllowed, factory);
}

struct CheckOptions {
  server::EnvironmentCheckOptions check;
  std::string traceFile;
  std::string configurationFile;
  double timeoutSeconds = 60.0;
};

/// The command that serves a plug-in in a process of its own, so that one that dies or hangs ends its check alone.
std::string servedPlugin(const CheckOptions& options) {
  const auto quoted = [](const std::string& text) { return conformance::quoted(text); };
  std::error_code error;
  return "stdio:" + quoted(fs::read_symlink("/proc/self/exe", error).string()) +
         " environment plugin --stdio --library " + quoted(options.check.address) +
         (options.configurationFile.empty() ? "" : " --configuration " + quoted(options.configurationFile));
}

int checkOther(CheckOptions& options) {
  const std::string& address = options.check.address;
  const bool isInLibrary = address.find("://") == std::string::npos && !address.starts_with("stdio:") &&
                           !address.starts_with("unix:") && isPluginFile(address);
  if (isInLibrary) {
    std::error_code error;
    if (!fs::is_regular_file(options.check.address, error)) {
      printError("there is no plug-in '" + options.check.address + "': check the name and the working folder");
      return kFailure;
    }
    options.check.address = servedPlugin(options);
  }
  std::unique_ptr<server::TraceFileSource> trace;
  if (!options.traceFile.empty()) {
    auto opened = server::TraceFileSource::open(options.traceFile);
    if (!opened) {
      printError(opened.error());
      return kFailure;
    }
    trace = std::move(*opened);
    options.check.trace = trace.get();
  }
  // a plug-in gets it when it is made
  if (!options.configurationFile.empty() && !isInLibrary) {
    auto text = server::DiskFileProvider().read(options.configurationFile);
    if (!text) {
      printError("the configuration file '" + options.configurationFile + "' cannot be read");
      return kFailure;
    }
    options.check.configurationJson = std::move(*text);
  }
  options.check.stepTimeout = std::chrono::milliseconds(static_cast<std::int64_t>(options.timeoutSeconds * 1e3));
  const bool isRight = server::checkEnvironment(options.check, [](const std::string& line) {
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
  });
  return isRight ? kSuccess : kFailure;
}

void addCheckOfOther(CLI::App& environment, int& status) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* command =
      environment.add_subcommand("check", "Test an environment in another process or a plug-in, without a simulation");
  command->footer(
      "Tests the description, shapes, units, independence of the order of queries, repeatability, numbers that are "
      "not\n"
      "finite, save and restore, and prints a table of latencies. Exit status 0 when every test passes. With --trace "
      "the\n"
      "environment gets the queries of a recorded run, and its replies are compared with the recorded ones. A plug-in "
      "is\n"
      "called in a process of its own.\n"
      "  espalier environment check 'stdio:python3 light.py'\n"
      "  espalier environment check ./libceiling.so\n"
      "  espalier derive tree.l --environment old.json --trace tree.trace\n"
      "  espalier environment check tcp://127.0.0.1:4000 --trace tree.trace");
  command
      ->add_option("ADDRESS", options->check.address,
                   "tcp://HOST:PORT, unix:PATH, stdio:COMMAND, or the file of a plug-in (.so)")
      ->required();
  command->add_option("--trace", options->traceFile, "Trace file that derive, run or a server recorded");
  command->add_option("--configuration", options->configurationFile,
                      "JSON file with the configuration for environment.open, or of the plug-in");
  command
      ->add_option("--timeout", options->timeoutSeconds,
                   "Longest time for a step, in seconds; for the first answer at most 20")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->callback([options, &status] { status = checkOther(*options); });
}

}  // namespace

void addEnvironment(CLI::App& program, int& status) {
  const auto options = std::make_shared<EnvironmentOptions>();
  CLI::App* command =
      program.add_subcommand("environment", "Run a built-in environment as its own process, or describe it");
  command->footer(
      "A model uses the environment from another process and grows exactly the same plant:\n"
      "  espalier environment honda --listen 127.0.0.1:4000 &\n"
      "  espalier derive MODEL.l --environment tcp://127.0.0.1:4000\n"
      "  espalier derive MODEL.l --environment 'stdio:espalier environment honda --stdio'\n"
      "An existing environment program that uses pipes (the protocol of cpfg) is served in the same way:\n"
      "  espalier environment legacy --executable './soil -v' --spec roots.e --listen 127.0.0.1:4000\n"
      "Quantities in space are not sent to the simulation; --field writes them where the environment runs:\n"
      "  espalier environment soil-water --configuration soil.json --listen 127.0.0.1:4000 --field water.vti\n"
      "With --listen it prints `listening on HOST:PORT` when it is ready, and serves until SIGINT or SIGTERM.\n"
      "`espalier environment check ADDRESS` tests an environment that you wrote.");
  command->add_option("NAME", options->name, "Name of a built-in environment (see --list), legacy or plugin");
  command->add_option("--listen", options->address, "Serve on HOST:PORT; port 0 takes a free port");
  command->add_flag("--insecure", options->isInsecureAllowed,
                    "Serve on an address that other machines can reach, without encryption and without a token");
  command->add_flag("--stdio", options->isOnStdio, "Serve on standard input and output until the input ends");
  command->add_option("--configuration", options->configurationFile,
                      "JSON file with the configuration (see --schema), with or without the member \"type\"");
  command->add_option("--executable", options->executable,
                      "For NAME legacy: the program and its arguments, instead of the `executable` of the .e file");
  command->add_option("--spec", options->fieldFile,
                      "For NAME legacy: the environment file (.e) that defines the values sent to the program");
  command->add_option("--library", options->library, "For NAME plugin: the shared library (environment/plugin.h)");
  command->add_option("--time-limit", options->timeLimitSeconds, "For NAME legacy: longest time for a step, in seconds")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  CLI::Option* describe = command->add_flag(
      "--describe", options->describes,
      "Print in words: what it computes, what a module sends and gets, its source, and the keys of its configuration");
  command->add_flag("--json", options->isJson, "With --describe: print the same as JSON, for programs")
      ->needs(describe);
  command->add_flag("--schema", options->printsSchema, "Print the JSON Schema of the configuration");
  command->add_flag("--list", options->lists, "Print the name of every built-in environment with a summary");
  options->fields.addTo(*command);
  command->add_flag("--every", options->writesEveryStep,
                    "Write the files of --field for every step, numbered, instead of the last step only");
  addCheckOfOther(*command, status);
  command->callback([options, &status, command] {
    if (command->get_subcommands().empty()) {
      status = runEnvironment(*options);
    }
  });
}

}  // namespace espalier::command
