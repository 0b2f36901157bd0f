#include "server/running/environment_builder.h"

#include <algorithm>
#include <filesystem>

#include "engine/core/streams.h"
#include "environment/environment_entries.h"
#include "environment/environment_set.h"
#include "environment/published/published_environment.h"
#include "environment/registry.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"
#include "protocol/json_writer.h"
#include "server/remote/channel_link.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"
#include "server/remote/offered_environments.h"
#include "server/remote/remote_process.h"
#include "server/remote/remote_settings.h"

namespace espalier::server {
namespace {

std::string sentences(const std::vector<core::Diagnostic>& diagnostics) {
  std::string text;
  for (const core::Diagnostic& diagnostic : diagnostics) {
    text += (text.empty() ? "" : "; ") + diagnostic.message;
    if (!diagnostic.hint.empty()) {
      text += ": " + diagnostic.hint;
    }
  }
  return text;
}

protocol::Error environmentFailed(const std::string& name, const turtle::EnvironmentError& error) {
  protocol::JsonWriter data;
  data.beginObject().key("environment").text(name).key("step").integer(std::uint64_t{0});
  data.key("retryable").boolean(error.isRetryable).endObject();
  return {protocol::ErrorCode::EnvironmentFailed, error.message, data.take()};
}

bool isRemote(const std::string& type) {
  return type == "offered" || type == "tcp" || type == "stdio";
}

/// The address of a `tcp` entry without its scheme.
std::string addressOf(const environment::EnvironmentEntry& entry) {
  std::string address = protocol::memberOf(entry.configuration, "address").value_or("");
  return address.starts_with("tcp://") ? address.substr(6) : address;
}

/// The name of the listed command that an entry of the type `stdio` wants. Empty: it has none.
std::string spawnNameOf(const environment::EnvironmentEntry& entry) {
  return entry.name == entry.type ? std::string() : entry.name;
}

protocol::Error unauthorised(const std::string& path, const std::string& what) {
  protocol::JsonWriter data;
  data.beginObject().key("path").text(path).endObject();
  return {protocol::ErrorCode::Unauthorised, path + ": " + what, data.take()};
}

/// Why an entry may not start its command or dial its address, or nothing.
std::optional<protocol::Error> refusalOf(const environment::EnvironmentEntry& entry, const std::string& path,
                                         const RemotePermissions& permissions) {
  if (entry.type == "tcp") {
    const std::string address = addressOf(entry);
    if (address.empty() || permissions.mayDial(address)) {
      return std::nullopt;
    }
    return unauthorised(path + ".address", "the server may not dial '" + address + "'. Start it with --allow-dial " +
                                               address + ", or let the environment offer itself.");
  }
  if (entry.type != "stdio") {
    return std::nullopt;
  }
  if (protocol::memberOf(entry.configuration, "command")) {
    if (permissions.isSpawnAllowed) {
      return std::nullopt;
    }
    return unauthorised(path + ".command",
                        "the server starts only commands that its operator lists under [spawn] of its configuration. "
                        "Send {\"type\":\"stdio\",\"name\":NAME} with the NAME of one of them, or let the environment "
                        "offer itself. A private server may start with --allow-spawn.");
  }
  const std::string name = spawnNameOf(entry);
  if (name.empty()) {
    return protocol::memberError(path + ".name", "expected the name of a command that the server lists under [spawn]");
  }
  const auto arguments = protocol::memberOf(entry.configuration, "arguments");
  if (arguments && !protocol::listOf(entry.configuration, "arguments")) {
    return protocol::memberError(path + ".arguments", "expected a list of texts");
  }
  if (const auto problem = permissions.problemOfName(name, arguments.has_value())) {
    return unauthorised(path + ".name", *problem);
  }
  return std::nullopt;
}

/// The link of a remote entry that is permitted, or what is wrong with it.
protocol::Expected<std::shared_ptr<EnvironmentLink>> makeLink(const environment::EnvironmentEntry& entry,
                                                              const std::string& path,
                                                              const EnvironmentServices& services) {
  if (entry.type == "offered") {
    if (entry.name == entry.type) {
      return tl::unexpected(
          protocol::memberError(path + ".name", "expected the name under which the environment offers itself"));
    }
    return std::make_shared<OfferedLink>(entry.name, *services.offered);
  }
  const ChannelOptions options{.connectTimeout = services.connectTimeout, .limits = services.frames};
  if (entry.type == "tcp") {
    std::string address = addressOf(entry);
    if (address.empty()) {
      return tl::unexpected(protocol::memberError(path + ".address", "expected HOST:PORT"));
    }
    if (address.starts_with("unix:")) {
      return tl::unexpected(
          protocol::memberError(path + ".address",
                                "a socket of this machine's file system is dialled by the command line only; let the "
                                "environment offer itself, or listen on HOST:PORT"));
    }
    return std::shared_ptr<EnvironmentLink>(ChannelLink::tcp(std::move(address), options));
  }
  if (auto command = protocol::memberOf(entry.configuration, "command")) {
    if (command->empty()) {
      return tl::unexpected(protocol::memberError(path + ".command", "expected a command"));
    }
    return std::shared_ptr<EnvironmentLink>(ChannelLink::stdio(std::move(*command), options));
  }
  const std::string name = spawnNameOf(entry);
  std::vector<std::string> words = services.permissions->spawn.at(name).words;
  const auto arguments = protocol::listOf(entry.configuration, "arguments").value_or(std::vector<std::string>{});
  words.insert(words.end(), arguments.begin(), arguments.end());
  return std::shared_ptr<EnvironmentLink>(ChannelLink::program(name, std::move(words), options));
}

/// How people read the name of an entry in another process.
std::string titleOf(const environment::EnvironmentEntry& entry) {
  const bool hasName =
      entry.type == "offered" || (entry.type == "stdio" && !protocol::memberOf(entry.configuration, "command"));
  return hasName ? entry.type + ":" + entry.name : entry.type;
}

/// The process that the environment file of a gallery model names. `origin` receives the files that it was made from,
/// by names in the gallery.
environment::ProcessOrErrors makeFromGallery(const environment::EnvironmentEntry& entry,
                                             core::Compatibility compatibility, const EnvironmentServices& services,
                                             simulation::EnvironmentOrigin& origin,
                                             std::vector<core::Diagnostic>& warnings) {
  const auto model = protocol::memberOf(entry.configuration, "model").value_or("");
  const auto folder = galleryFolderOf(services.galleryFolder, model);
  const std::string file = folder ? fileWithSuffix(*folder, model, ".e") : std::string();
  if (file.empty()) {
    return tl::unexpected(std::vector{core::Diagnostic{
        core::Severity::Error, "the gallery has no model '" + model + "' with an environment file (.e)", {}, {}}});
  }
  DiskFileProvider disk;
  core::RecordingFileProvider files(disk);
  auto made = environment::makeFromEnvironmentFile(file, files, compatibility, warnings);
  // where the gallery is on this machine stays unknown to clients
  const auto inGallery = [&services](const std::string& name) {
    return std::filesystem::path(name).lexically_relative(services.galleryFolder).generic_string();
  };
  origin = {inGallery(file), files.take()};
  for (auto& [name, text] : origin.files) {
    name = inGallery(name);
  }
  return made;
}

/// The process that a specification on the wire names. It can read only the files that came with it.
protocol::Expected<std::unique_ptr<turtle::EnvironmentProcess>> makeFromSentFiles(
    const environment::EnvironmentEntry& entry, const std::string& path, core::Compatibility compatibility,
    simulation::EnvironmentOrigin& origin, std::vector<core::Diagnostic>& warnings) {
  const auto main = protocol::memberOf(entry.configuration, "main");
  auto texts = protocol::textsOf(entry.configuration, "files");
  if (!texts) {
    return tl::unexpected(protocol::memberError(path + ".files", "expected an object of file names and their texts"));
  }
  if (!main || !texts->contains(*main)) {
    return tl::unexpected(protocol::memberError(
        path + ".main", "expected the name of the environment specification (.e) among \"files\""));
  }
  origin = {*main, {texts->begin(), texts->end()}};
  core::MemoryFileProvider files(std::move(*texts));
  auto made = environment::makeFromEnvironmentFile(*main, files, compatibility, warnings);
  if (!made) {
    return tl::unexpected(protocol::memberError(path, sentences(made.error())));
  }
  return std::move(*made);
}

}  // namespace

protocol::Expected<BuiltEnvironment> buildEnvironment(const std::string& environmentJson,
                                                      core::Compatibility compatibility, bool isAbsenceTolerated,
                                                      const EnvironmentServices& services) {
  BuiltEnvironment built;
  if (environmentJson.empty()) {
    return built;
  }
  auto parsed = environment::parseEnvironmentEntries(environmentJson);
  if (!parsed) {
    return tl::unexpected(protocol::memberError("params.environment", sentences(parsed.error())));
  }
  const std::vector<environment::EnvironmentEntry>& entries = *parsed;
  const RemotePermissions nothing;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (auto error = refusalOf(entries[i], "params.environment[" + std::to_string(i) + "]",
                               services.permissions == nullptr ? nothing : *services.permissions)) {
      return tl::unexpected(std::move(*error));
    }
  }
  std::vector<std::pair<std::string, std::unique_ptr<turtle::EnvironmentProcess>>> processes;
  simulation::EnvironmentOrigin fieldOrigin;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const environment::EnvironmentEntry& entry = entries[i];
    const std::string path = "params.environment[" + std::to_string(i) + "]";
    std::unique_ptr<turtle::EnvironmentProcess> process;
    if (isRemote(entry.type)) {
      auto made = makeLink(entry, path, services);
      if (!made) {
        return tl::unexpected(std::move(made.error()));
      }
      const auto& link = *made;
      auto read = readRemoteSettings(entry.configuration);
      if (!read) {
        return tl::unexpected(protocol::memberError(path + "." + read.error().key, read.error().message));
      }
      RemoteSettings& settings = *read;
      RemoteProcessOptions options;
      options.stepTimeout = std::min(services.stepTimeout, settings.stepTimeout.value_or(services.stepTimeout));
      options.configurationJson = std::move(settings.configurationJson);
      options.isAbsenceTolerated = isAbsenceTolerated;
      options.bounds = services.bounds;
      options.runWaiting = services.runWaiting;
      auto remote = std::make_unique<RemoteProcess>(link, std::move(options));
      if (auto error = remote->introduce();
          error && !((isAbsenceTolerated || settings.policy.isTolerant) && error->isRetryable)) {
        return tl::unexpected(environmentFailed(entry.name, *error));
      }
      built.links.push_back(link);
      built.names.push_back(titleOf(entry));
      process = settings.policy.around(std::move(remote), services.onFailure);
    } else if (entry.type == "field") {
      auto made = makeFromSentFiles(entry, path, compatibility, fieldOrigin, built.warnings);
      if (!made) {
        return tl::unexpected(std::move(made.error()));
      }
      process = std::move(*made);
      built.names.push_back(entry.name == entry.type ? *protocol::memberOf(entry.configuration, "main") : entry.name);
    } else {
      auto made = entry.type == "gallery" ? makeFromGallery(entry, compatibility, services, fieldOrigin, built.warnings)
                                          : environment::makeProcess(entry.type, entry.configuration);
      if (!made) {
        return tl::unexpected(protocol::memberError(path, sentences(made.error())));
      }
      process = std::move(*made);
      built.names.push_back(entry.type);
    }
    built.processNames.push_back(entry.name);
    // a single environment takes all queries, whatever they are called
    processes.emplace_back(entries.size() == 1 ? std::string() : entry.name, std::move(process));
  }
  // a specification alone is an environment by itself; anything else is a configuration
  const bool isFieldFile = entries.size() == 1 && !fieldOrigin.name.empty();
  built.origin = isFieldFile
                     ? std::move(fieldOrigin)
                     : simulation::EnvironmentOrigin{"environment.json", {{"environment.json", environmentJson}}};
  if (!processes.empty()) {
    built.process = environment::makeEnvironmentSet(std::move(processes));
  }
  return built;
}

std::string readableEnvironment(const std::string& environmentJson) {
  std::string list;
  const auto parsed = environment::parseEnvironmentEntries(environmentJson.empty() ? "[]" : environmentJson);
  for (const environment::EnvironmentEntry& entry : parsed.value_or(std::vector<environment::EnvironmentEntry>{})) {
    protocol::JsonWriter head;
    head.beginObject().key("type").text(entry.type);
    if (entry.name != entry.type) {
      head.key("name").text(entry.name);
    }
    std::string text = head.endObject().take();
    if (!isRemote(entry.type) && entry.configuration.size() > 2) {
      text.back() = ',';
      text += std::string_view(entry.configuration).substr(1);
    }
    list += (list.empty() ? "" : ",") + text;
  }
  return "[" + list + "]";
}

}  // namespace espalier::server
