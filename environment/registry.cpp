#include "environment/registry.h"

#include <algorithm>
#include <array>
#include <utility>

#include "environment/base/process_entry.h"
#include "environment/competition/colonization.h"
#include "environment/competition/crowding.h"
#include "environment/competition/density.h"
#include "environment/competition/density3d.h"
#include "environment/competition/ecosystem.h"
#include "environment/competition/honda.h"
#include "environment/competition/meadow.h"
#include "environment/competition/ornament.h"
#include "environment/directions/attractors.h"
#include "environment/directions/constant.h"
#include "environment/directions/gravity.h"
#include "environment/directions/height.h"
#include "environment/directions/wind.h"
#include "environment/light/chiba.h"
#include "environment/light/clover.h"
#include "environment/light/rays/light.h"
#include "environment/light/shadow.h"
#include "environment/light/takenaka.h"
#include "environment/light/voxels/light_voxels.h"
#include "environment/multiple.h"
#include "environment/obstacles/arvo.h"
#include "environment/obstacles/obstacles.h"
#include "environment/soil/emission.h"
#include "environment/soil/soil.h"
#include "environment/soil/soil_water.h"

namespace espalier::environment {

namespace {

// sorted by name
constexpr std::array kProcesses{
    &kArvoProcess,        &kAttractorsProcess, &kChibaProcess,     &kCloverProcess,    &kColonizationProcess,
    &kConstantProcess,    &kCrowdingProcess,   &kDensityProcess,   &kDensity3dProcess, &kEcosystemProcess,
    &kEmissionProcess,    &kGravityProcess,    &kHeightProcess,    &kHondaProcess,     &kLightProcess,
    &kLightVoxelsProcess, &kMeadowProcess,     &kMultipleProcess,  &kObstaclesProcess, &kOrnamentProcess,
    &kShadowProcess,      &kSoilProcess,       &kSoilWaterProcess, &kTakenakaProcess,  &kWindProcess};

}  // namespace

const ProcessEntry* findProcess(std::string_view name) {
  for (const ProcessEntry* entry : kProcesses) {
    if (entry->name == name || std::find(entry->aliases.begin(), entry->aliases.end(), name) != entry->aliases.end()) {
      return entry;
    }
  }
  return nullptr;
}

core::Diagnostic unknownProcess(std::string_view name) {
  std::vector<std::string_view> names;
  for (const ProcessEntry* entry : kProcesses) {
    names.push_back(entry->name);
  }
  core::Diagnostic diagnostic;
  diagnostic.message = "environment process '" + std::string(name) + "' is unknown. " + core::suggestName(name, names);
  return diagnostic;
}

std::vector<std::string> processNames() {
  std::vector<std::string> names;
  for (const ProcessEntry* entry : kProcesses) {
    names.emplace_back(entry->name);
  }
  return names;
}

std::string canonicalName(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return std::string(entry == nullptr ? name : entry->name);
}

std::vector<std::string> aliasesOf(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return entry == nullptr ? std::vector<std::string>()
                          : std::vector<std::string>(entry->aliases.begin(), entry->aliases.end());
}

std::string sourceOf(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return std::string(entry == nullptr ? std::string_view() : entry->source);
}

std::string configurationSchema(std::string_view name) {
  const ProcessEntry* entry = findProcess(name);
  return entry == nullptr ? std::string() : writeSchema(entry->name, entry->summary, entry->keys);
}

ProcessOrErrors makeProcess(std::string_view name, std::string_view configurationJson) {
  const ProcessEntry* entry = findProcess(name);
  if (entry == nullptr) {
    return std::vector<core::Diagnostic>{unknownProcess(name)};
  }
  auto configuration = readConfiguration(entry->name, entry->keys, configurationJson);
  if (auto* errors = std::get_if<std::vector<ConfigurationError>>(&configuration)) {
    std::vector<core::Diagnostic> diagnostics;
    for (ConfigurationError& error : *errors) {
      diagnostics.push_back(std::move(error.diagnostic));
    }
    return diagnostics;
  }
  return entry->make(std::get<Configuration>(configuration));
}

}  // namespace espalier::environment
