#include <filesystem>
#include <nlohmann/json.hpp>

#include "clients/bmi/espalier_bmi.h"
#include "clients/bmi/stepped_model.h"
#include "engine/files/file_name.h"
#include "environment/environment_entries.h"
#include "environment/environment_set.h"
#include "environment/published/published_environment.h"
#include "environment/registry.h"
#include "server/remote/disk_files.h"
#include "server/remote/processes/plugin_library.h"
#include "server/remote/remote_environment.h"
#include "server/remote/terrain/terrain_embedding.h"

namespace espalier::bmi {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

Process orThrow(environment::ProcessOrErrors made) {
  if (!made) {
    throw BmiError(core::formatDiagnostic(made.error().front()));
  }
  return std::move(*made);
}

Process orThrow(tl::expected<Process, std::string> made) {
  if (!made) {
    throw BmiError(made.error());
  }
  return std::move(*made);
}

/// The text of an entry's member; throws without it.
std::string memberOf(const environment::EnvironmentEntry& entry, const char* member) {
  const auto read = nlohmann::json::parse(entry.configuration.empty() ? "{}" : entry.configuration, nullptr, false);
  if (!read.is_object() || !read.contains(member) || !read[member].is_string()) {
    throw BmiError("the environment '" + entry.name + "' needs a member '" + member + "', a text.");
  }
  return read[member].get<std::string>();
}

Process makeEntry(const environment::EnvironmentEntry& entry, const std::string& file, bool isTrusted) {
  const bool isOutside = entry.type == "plugin" || entry.type == "tcp" || entry.type == "stdio";
  if (!isOutside) {
    return orThrow(environment::makeProcess(entry.type, entry.configuration));
  }
  if (!isTrusted) {
    throw BmiError(file + " asks for the environment '" + entry.name +
                   "' in another program, and it may come from a stranger: give it as 'environment' of the "
                   "configuration if you trust it.");
  }
  if (entry.type == "plugin") {
    return orThrow(server::loadPluginProcess(files::nameBeside(file, memberOf(entry, "library")), entry.configuration));
  }
  const bool isTcp = entry.type == "tcp";
  return orThrow(server::connectRemoteEnvironment(
      isTcp ? "tcp://" + memberOf(entry, "address") : "stdio:" + memberOf(entry, "command"), {}));
}

/// The environments of a JSON text: an object or a list of them. `file` is where it stands.
Process ofEntries(const std::string& json, const std::string& file, bool isTrusted) {
  server::DiskFileProvider disk;
  auto entries = environment::parseEnvironmentEntries(json);
  if (!entries) {
    throw BmiError(file + ": " + core::formatDiagnostic(entries.error().front()));
  }
  std::vector<std::pair<std::string, Process>> made;
  for (environment::EnvironmentEntry& entry : *entries) {
    if (const auto problem = server::embedAllFiles(entry, file, disk)) {
      throw BmiError(core::formatDiagnostic(*problem));
    }
    // a single environment answers all queries, of any name
    made.emplace_back(entries->size() == 1 ? std::string{} : entry.name, makeEntry(entry, file, isTrusted));
  }
  return made.empty() ? nullptr : environment::makeEnvironmentSet(std::move(made));
}

/// The environment of a file, `.json` or `.e`.
Process ofFile(const std::string& file, core::Compatibility compatibility, bool isTrusted) {
  server::DiskFileProvider disk;
  const std::optional<std::string> text = disk.read(file);
  if (!text) {
    throw BmiError("there is no environment file '" + file + "': check the name.");
  }
  if (files::endsIn(file, ".json")) {
    return ofEntries(*text, file, isTrusted);
  }
  std::vector<core::Diagnostic> warnings;
  return orThrow(environment::makeFromEnvironmentFile(file, disk, compatibility, warnings));
}

}  // namespace

Process makeEnvironmentOf(const Settings& settings, const std::string& folderFile, core::Compatibility compatibility) {
  if (settings.environment.empty()) {
    return folderFile.empty() ? nullptr : ofFile(folderFile, compatibility, false);
  }
  const auto given = nlohmann::json::parse(settings.environment);
  if (!given.is_string()) {
    return ofEntries(settings.environment, settings.file, true);
  }
  const std::string name = given.get<std::string>();
  if (name.starts_with("tcp://") || name.starts_with("unix:") || name.starts_with("stdio:")) {
    return orThrow(server::connectRemoteEnvironment(name, {}));
  }
  const std::string beside = files::nameBeside(settings.file, name);
  if (files::endsIn(name, ".so")) {
    return orThrow(server::loadPluginProcess(beside, "{}"));
  }
  // no built-in process has a name like a file
  return name.find_first_of("./") == std::string::npos ? orThrow(environment::makeProcess(name, ""))
                                                       : ofFile(beside, compatibility, true);
}

}  // namespace espalier::bmi
