#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <thread>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/installation/handbook_files.h"
#include "clients/espalier/installation/service_notification.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/serve_configuration.h"
#include "clients/web/pages.h"
#include "server/remote/models/gallery.h"
#include "server/remote/processes/line_channel.h"
#include "server/server.h"

namespace espalier::command {
namespace {

struct ServeOptions {
  std::string address = "127.0.0.1:4321";
  std::string http;  // HOST:PORT; empty: none
  std::string token;
  std::string tokenFile;
  std::string configuration;  // file
  std::string handbook;       // folder; empty: what came with the program
  bool isConfigurationPrinted = false;
  bool endsWithInput = false;
  std::string durability = "process";
  std::vector<std::string> limits;  // NAME=NUMBER
  server::ServerOptions server;
};

/// The names of all limits with their meanings and defaults, for --help.
std::string limitHelp() {
  const server::ServerLimits defaults;
  std::string text = "NAME=NUMBER. May be repeated. Limits with their defaults:";
  for (const server::LimitEntry& entry : server::limitEntries()) {
    text += "\n  " + std::string(entry.name) + "  " + std::string(entry.meaning) + " (" +
            std::to_string(entry.get(defaults)) + ")";
  }
  return text;
}

// a sentence about a file with a token that other users may read; nothing when it is private or missing
std::optional<std::string> whyOpenToOthers(const std::string& file) {
  struct stat permissions {};
  if (::stat(file.c_str(), &permissions) != 0 || (permissions.st_mode & (S_IRWXG | S_IRWXO)) == 0) {
    return std::nullopt;
  }
  return "other users of the machine may read or change the token file '" + file + "': chmod 600 " + file;
}

/// Adds the token of --token or of the first line of --token-file. An error sentence when there is none in the file,
/// or when other users may read it.
std::optional<std::string> addOwnToken(const ServeOptions& options, std::vector<server::Token>& tokens) {
  std::string text = options.token;
  if (!options.tokenFile.empty()) {
    if (auto problem = whyOpenToOthers(options.tokenFile)) {
      return problem;
    }
    std::ifstream file(options.tokenFile);
    if (!std::getline(file, text) || text.empty()) {
      return "the token file '" + options.tokenFile + "' cannot be read, or its first line is empty";
    }
  }
  if (!text.empty()) {
    tokens.push_back(server::tokenOf("token", text, {protocol::Role::Controller}));
  }
  return std::nullopt;
}

/// Why a file cannot be read again while the server runs, or nothing.
std::optional<std::string> whyUnreadable(const std::string& file) {
  std::error_code unknown;
  // a pipe would keep its reader waiting for ever
  return std::filesystem::is_regular_file(file, unknown)
             ? std::nullopt
             : std::optional("'" + file + "' is not there, or is no regular file");
}

/// Sets the limits of --limit, which win over those of a configuration. An error sentence, or nothing.
std::optional<std::string> applyLimits(const ServeOptions& options, server::ServerLimits& limits) {
  for (const std::string& limit : options.limits) {
    if (auto problem = server::setLimit(limits, limit)) {
      return problem;
    }
  }
  return std::nullopt;
}

/// The content of a configuration when the server was started.
struct AtStart {
  std::map<std::string, std::vector<std::string>> items;  // beside limits and tokens
  bool hasLimits = false;
};

/// The names of the items that the configuration has now and did not have at the start, or that it has no more.
std::vector<std::string> changedKeys(const AtStart& atStart, std::map<std::string, std::vector<std::string>> items) {
  std::vector<std::string> changed;
  for (const auto& [key, values] : atStart.items) {
    const auto found = items.find(key);
    if (found == items.end() || found->second != values) {
      changed.push_back(key);
    }
    if (found != items.end()) {
      items.erase(found);
    }
  }
  for (const auto& [key, values] : items) {
    changed.push_back(key);
  }
  return changed;
}

/// The tokens and limits of the files as they are now, with those of the command line. An error sentence for the first
/// mistake in any of them.
tl::expected<server::ServerOptions::ReadAgain, std::string> readAgain(const CLI::App& command,
                                                                      const ServeOptions& options,
                                                                      const AtStart& atStart) {
  for (const std::string& file : {options.configuration, options.tokenFile}) {
    if (auto problem = file.empty() ? std::nullopt : whyUnreadable(file)) {
      return tl::unexpected(std::move(*problem));
    }
  }
  server::ServerOptions::ReadAgain read;
  if (!options.configuration.empty()) {
    auto configured = readConfigurationAgain(command, options.configuration, atStart.hasLimits);
    if (!configured) {
      return tl::unexpected(std::move(configured.error()));
    }
    if (auto problem = applyLimits(options, configured->limits)) {
      return tl::unexpected(std::move(*problem));
    }
    read.tokens = std::move(configured->tokens);
    read.limits = configured->limits;
    read.restartKeys = changedKeys(atStart, std::move(configured->items));
  }
  if (auto problem = addOwnToken(options, read.tokens)) {
    return tl::unexpected(std::move(*problem));
  }
  return read;
}

// the system closes the input when the program at its other end ends, in whatever way
void endWithInput() {
  char bytes[256];
  ssize_t count = 0;
  do {
    count = ::read(STDIN_FILENO, bytes, sizeof bytes);
  } while (count > 0 || (count < 0 && errno == EINTR));
  (void)::kill(::getpid(), SIGTERM);
}

int runServe(CLI::App& command, ServeOptions& options) {
  if (!options.configuration.empty()) {
    if (const auto problem = readServeConfiguration(command, options.configuration, options.server)) {
      printError(*problem);
      return kUsage;
    }
  }
  const bool isUnixSocket = options.address.starts_with("unix:") && options.address.size() > 5;
  if (isUnixSocket) {
    options.server.host = options.address;
  } else if (!server::splitAddress(options.address, options.server.host, options.server.port)) {
    printError("'" + options.address +
               "' is not an address: write HOST:PORT, for example 127.0.0.1:4321, or unix:PATH");
    return kUsage;
  }
  if (!options.http.empty() && !server::splitAddress(options.http, options.server.httpHost, options.server.httpPort)) {
    printError("'" + options.http + "' is not an address: write HOST:PORT, for example 127.0.0.1:8080");
    return kUsage;
  }
  for (const std::string& origin : options.server.allowedOrigins) {
    if (origin.find("://") == std::string::npos) {
      printError("--allow-origin '" + origin + "' is no origin of a page: write https://HOST or https://HOST:PORT");
      return kUsage;
    }
  }
  for (const std::string& address : options.server.remote.addresses) {
    std::string host;
    std::uint16_t port = 0;
    if (address != "any" && !server::splitAddress(address, host, port)) {
      printError("--allow-dial '" + address +
                 "' is not an address: write HOST:PORT, for example 127.0.0.1:4000, or any");
      return kUsage;
    }
  }
  if (const auto problem = applyLimits(options, options.server.limits)) {
    printError(*problem);
    return kUsage;
  }
  options.server.durability = server::durabilityOf(options.durability).value_or(server::Durability::Process);
  if (options.isConfigurationPrinted) {
    const std::string text = serveConfigurationText(command, options.server);
    std::fwrite(text.data(), 1, text.size(), stdout);
    return kSuccess;
  }
  if (command.count("--gallery") == 0 && options.server.galleryFolder.empty()) {
    options.server.galleryFolder = server::galleryOfProgram();
  }
  if (const auto problem = addOwnToken(options, options.server.tokens)) {
    printError(*problem);
    return kFailure;
  }
  if (!options.configuration.empty() || !options.tokenFile.empty()) {
    const AtStart atStart{readStartItems(options.configuration), setsLimits(options.configuration)};
    options.server.readAgain = [&command, &options, atStart] { return readAgain(command, options, atStart); };
  }
  // a file that reaches the size limit fails one saving and does not end the server
  (void)std::signal(SIGXFSZ, SIG_IGN);
  // nor does the end of the program that reads the log
  (void)std::signal(SIGPIPE, SIG_IGN);
  const auto hostOf = [](const std::string& address) { return address.substr(0, address.rfind(':')); };
  options.server.pages = {{"/", "text/html; charset=utf-8", web::serverPage()},
                          {"/studio.js", "text/javascript; charset=utf-8", web::script(), web::packedScript()},
                          {"/studio.css", "text/css; charset=utf-8", web::style()}};
  HandbookFiles handbook;
  if (options.http.empty() && !options.handbook.empty()) {
    printError("--handbook is for browsers, and no address for them is given: add --http HOST:PORT");
    return kUsage;
  }
  if (options.http.empty() && !options.server.allowedOrigins.empty()) {
    printError("--allow-origin is for browsers, and no address for them is given: add --http HOST:PORT");
    return kUsage;
  }
  if (!options.http.empty()) {
    auto read = HandbookFiles::read(options.handbook.empty() ? server::handbookOfProgram() : options.handbook);
    if (!read && !options.handbook.empty()) {
      printError(read.error());
      return kFailure;
    }
    if (read) {
      handbook = std::move(*read);
    }
    handbook.addTo(options.server.pages);
  }
  options.server.readySignal = [] { notifyService("READY=1"); };
  options.server.aliveSignal = watchdogSignal();
  server::Server server(std::move(options.server));
  if (const auto problem = server.listen()) {
    printError(*problem);
    return kFailure;
  }
  if (isUnixSocket) {
    std::printf("listening on %s\n", options.address.c_str());
  } else {
    std::printf("listening on %s:%u\n", hostOf(options.address).c_str(), static_cast<unsigned>(server.port()));
  }
  if (!options.http.empty()) {
    std::printf("http on %s:%u\n", hostOf(options.http).c_str(), static_cast<unsigned>(server.httpPort()));
  }
  std::fflush(stdout);
  if (options.endsWithInput) {
    std::thread(endWithInput).detach();
  }
  server.run(true);
  notifyService("STOPPING=1");
  return kSuccess;
}

}  // namespace

void addServe(CLI::App& program, int& status) {
  const auto options = std::make_shared<ServeOptions>();
  CLI::App* command = program.add_subcommand("serve", "Run the simulation server until SIGINT or SIGTERM");
  command->footer(
      "When the server is ready it prints `listening on 127.0.0.1:PORT` on standard output. Its log goes to standard\n"
      "error. Clients use the protocol espalier/1: one JSON object per line (protocol/README.md). Examples:\n"
      "  espalier serve --listen 127.0.0.1:4321 --data plants &\n"
      "  espalier connect 127.0.0.1:4321 create MODEL.l\n"
      "With --data the server saves every simulation after each step, unless its client asked for no saving. The next\n"
      "server with the same folder loads the simulations again, also after a crash. Only one server at a time may use\n"
      "a folder.");
  command
      ->add_option("--listen", options->address,
                   "HOST:PORT; port 0 takes a free port. An address that other machines can reach needs a token, and a "
                   "certificate or --insecure. unix:PATH: a socket for programs of this user")
      ->capture_default_str();
  command->add_option(
      "--http", options->http,
      "HOST:PORT for browsers and monitoring: a page at / that grows plants, WebSockets at /espalier/1, /metrics, "
      "/health");
  CLI::Option* certificate = command->add_option("--certificate", options->server.certificateFile,
                                                 "PEM file of a certificate; encrypts all connections (TLS)");
  CLI::Option* key =
      command->add_option("--key", options->server.keyFile, "PEM file of the private key of the certificate");
  certificate->needs(key);
  key->needs(certificate);
  command->add_option("--allow-origin", options->server.allowedOrigins,
                      "Origin of other web pages that may open WebSockets, such as https://HOST. May be repeated");
  command->add_option("--data", options->server.dataFolder,
                      "Folder for saved simulations; the server makes it when it is missing");
  command
      ->add_option(
          "--durability", options->durability,
          "What \"saved\" survives: process (the end of the server), or power (also a power failure: the disk is "
          "asked to keep each save before its answer). In a configuration: [store] durability = \"power\"")
      ->check(CLI::IsMember({"process", "power"}))
      ->capture_default_str();
  command->add_option(
      "--models", options->server.modelsFolder,
      "Folder in which controllers keep models: the studio opens them and saves there. A folder for each model");
  command->add_option(
      "--gallery", options->server.galleryFolder,
      "Folder of model folders that clients use by name: {\"gallery\":\"NAME\"} (default: the gallery that "
      "came with the program)");
  command->add_option(
      "--handbook", options->handbook,
      "Folder of the built handbook, for /handbook of the HTTP side (default: the one that came with the program)");
  command->add_option("--token", options->token, "Token that clients send in hello; it allows everything");
  command->add_option(
      "--token-file", options->tokenFile,
      "File with the token in its first line; unlike --token, other users of the machine cannot see it");
  command->add_flag("--insecure", options->server.isInsecureAllowed,
                    "Allow an address that other machines can reach without encryption");
  command->add_flag("--allow-spawn", options->server.remote.isSpawnAllowed,
                    "Allow every controller to start any command as an environment (`stdio`), for private servers. "
                    "Without it only commands of the section [spawn] of the configuration are started");
  command->add_option("--allow-dial", options->server.remote.addresses,
                      "HOST:PORT of an environment that clients may name (`tcp`), or any. May be repeated");
  command
      ->add_option("--workers", options->server.workers,
                   "Simulations that compute at the same time; 0: as many as the process has processors")
      ->capture_default_str();
  command->add_option("--threads", options->server.threads, "Threads for one step; useful with few large plants")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  command->add_option("--limit", options->limits, limitHelp());
  command->add_option("--log-level", options->server.logLevel, "trace, debug, info, warn, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  command->add_option("--log-format", options->server.logFormat, "text, or json (one object per line)")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
  command->add_flag(
      "--until-input-ends", options->endsWithInput,
      "End the server when its standard input ends, so that it never outlives the program that started it");
  command->add_option("--config", options->configuration,
                      "TOML file with these options without dashes and the sections [limits], [store], [spawn] and "
                      "[tokens]; the command line wins");
  command->add_flag("--print-config", options->isConfigurationPrinted,
                    "Print the effective options and limits as a configuration file, and exit");
  command->callback([options, command, &status] { status = runServe(*command, *options); });
}

}  // namespace espalier::command
