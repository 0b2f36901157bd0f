#include "environment/registry.h"

#include <algorithm>
#include <array>
#include <utility>

#include "environment/arvo.h"
#include "environment/attractors.h"
#include "environment/chiba.h"
#include "environment/clover.h"
#include "environment/colonization.h"
#include "environment/constant.h"
#include "environment/crowding.h"
#include "environment/density.h"
#include "environment/density3d.h"
#include "environment/ecosystem.h"
#include "environment/emission.h"
#include "environment/gravity.h"
#include "environment/height.h"
#include "environment/honda.h"
#include "environment/light/light.h"
#include "environment/light/light_voxels.h"
#include "environment/meadow.h"
#include "environment/multiple.h"
#include "environment/obstacles.h"
#include "environment/ornament.h"
#include "environment/process_entry.h"
#include "environment/shadow.h"
#include "environment/soil.h"
#include "environment/soil_water/soil_water.h"
#include "environment/takenaka.h"
#include "environment/wind.h"

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
