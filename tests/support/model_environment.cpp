#include "tests/support/model_environment.h"

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "environment/environment_entries.h"
#include "environment/environment_set.h"
#include "environment/output/field_embedding.h"
#include "environment/output/mesh_embedding.h"
#include "environment/published/published_environment.h"
#include "environment/registry.h"

namespace espalier::test {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

[[noreturn]] void refuse(const std::string& file, const core::Diagnostic& error) {
  throw std::runtime_error(file + ": " + error.message);
}

Process processOf(environment::EnvironmentEntry& entry, const std::string& file, core::FileProvider& files) {
  auto problem = environment::embedMeshFile(entry, file, files);
  problem = problem ? problem : environment::embedFieldFile(entry, file, files);
  if (problem) {
    refuse(file, *problem);
  }
  auto made = environment::makeProcess(entry.type, entry.configuration);
  if (!made) {
    refuse(file, made.error().front());
  }
  return std::move(*made);
}

}  // namespace

std::string environmentFileBeside(const std::string& model, core::FileProvider& files) {
  for (const char* suffix : {".e", ".json"}) {
    const std::string file = std::filesystem::path(model).replace_extension(suffix).string();
    if (files.read(file)) {
      return file;
    }
  }
  return {};
}

Process environmentBeside(const std::string& model, core::FileProvider& files) {
  const std::string file = environmentFileBeside(model, files);
  if (file.empty()) {
    return nullptr;
  }
  if (file.ends_with(".e")) {
    std::vector<core::Diagnostic> warnings;
    auto made = environment::makeFromEnvironmentFile(file, files, core::Compatibility::Espalier, warnings);
    if (!made) {
      refuse(file, made.error().front());
    }
    return std::move(*made);
  }
  auto entries = environment::parseEnvironmentEntries(files.read(file).value_or(""));
  if (!entries) {
    refuse(file, entries.error().front());
  }
  // a single environment answers the queries of every name
  const bool isAlone = entries->size() == 1;
  std::vector<std::pair<std::string, Process>> processes;
  for (environment::EnvironmentEntry& entry : *entries) {
    Process process = processOf(entry, file, files);
    processes.emplace_back(isAlone ? "" : entry.name, std::move(process));
  }
  return environment::makeEnvironmentSet(std::move(processes));
}

}  // namespace espalier::test
