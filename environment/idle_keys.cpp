#include "environment/idle_keys.h"

#include <algorithm>
#include <string>

#include "environment/base/configuration.h"
#include "environment/base/json_text.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

/// When a key has no effect.
struct Rule {
  std::string_view process;
  std::string_view key;
  std::string_view other;
  /// The key works while `other` is one of these, with a bar between them; "given": while it is given; empty: while
  /// not.
  std::string_view working;
};

constexpr Rule kRules[]{
    {"soil-water", "topHead", "surface", "head"},
    {"soil-water", "bottomHead", "bottom", "head"},
    {"soil-water", "rain", "surface", "weather"},
    {"soil-water", "evaporation", "surface", "weather"},
    {"soil-water", "initialHead", "initially", "head"},
    {"soil-water", "initialHead", "initialHeads", ""},
    {"soil-water", "waterTableDepth", "initially", "waterTable"},
    {"soil-water", "roughness", "evaporationBy", "weather"},
    {"soil-water", "windHeight", "evaporationBy", "weather"},
    {"soil-water", "albedo", "evaporationBy", "weather"},
    {"soil-water", "longWaveLoss", "evaporationBy", "weather"},
    {"soil-water", "airPressure", "evaporationBy", "weather"},
    {"xylem", "transpiration", "collar", "flow"},
    {"xylem", "dayCourse", "collar", "flow"},
    {"xylem", "lowestHead", "collar", "flow"},
    {"xylem", "collarHead", "collar", "head"},
    {"xylem", "soilHead", "soilHeads", ""},
    {"xylem", "soilHead", "soil", ""},
    {"xylem", "soilHeads", "soil", ""},
    {"xylem", "rhizosphere", "soil", "given"},
    {"xylem", "kr", "krTable", ""},
    {"xylem", "kx", "kxTable", ""},
    {"light", "sunDirection", "sun", "direction"},
    {"light", "sunAzimuths", "sun", "direction"},
    {"light", "directIrradiance", "sun", "direction"},
    {"light", "diffuseIrradiance", "sun", "none|direction"},
    {"light", "start", "sun", "position"},
    {"light", "latitude", "sun", "position"},
    {"light", "longitude", "sun", "position"},
    {"light", "atmosphere", "sun", "position"},
    {"light", "sunSamples", "sun", "position"},
    {"light", "groundReflectance", "ground", "true"},
    {"light-voxels", "ellipsoidRatio", "leafAngles", "ellipsoidal"},
    {"light-voxels", "sun", "method", "turbid"},
    {"light-voxels", "unit", "method", "turbid"},
    {"light-voxels", "bands", "method", "turbid"},
    {"light-voxels", "sky", "directions", ""},
    {"light-voxels", "irradiance", "sun", "none"},
    {"light-voxels", "irradiance", "unit", "W|umol|mol"},
    {"light-voxels", "photonsPerJoule", "unit", "umol|mol"},
    {"light-voxels", "sunDirection", "sun", "direction"},
    {"light-voxels", "sunAzimuths", "sun", "direction"},
    {"light-voxels", "directIrradiance", "sun", "direction"},
    {"light-voxels", "diffuseIrradiance", "sun", "direction"},
    {"light-voxels", "start", "sun", "position"},
    {"light-voxels", "latitude", "sun", "position"},
    {"light-voxels", "longitude", "sun", "position"},
    {"light-voxels", "atmosphere", "sun", "position"},
    {"light-voxels", "sunSamples", "sun", "position"},
    {"light-voxels", "reflectance", "scattering", "true"},
    {"light-voxels", "transmittance", "scattering", "true"},
    {"light-voxels", "groundReflectance", "scattering", "true"},
};

std::string valueOf(const Configuration& configuration, const ConfigurationKey& key) {
  return key.kind == KeyKind::Boolean ? (configuration.flag(key.name) ? "true" : "false")
                                      : configuration.text(key.name);
}

bool isOneOf(std::string_view value, std::string_view working) {
  for (std::size_t begin = 0; begin <= working.size();) {
    const std::size_t end = std::min(working.find('|', begin), working.size());
    if (working.substr(begin, end - begin) == value) {
      return true;
    }
    begin = end + 1;
  }
  return false;
}

/// Whether a key is given, and is no empty list.
bool isThere(const Configuration& configuration, const ConfigurationKey& key) {
  const bool isEmpty = (key.kind == KeyKind::Rows && configuration.rows(key.name).empty()) ||
                       (key.kind == KeyKind::Numbers && configuration.numbers(key.name).empty()) ||
                       (key.kind == KeyKind::Entries && configuration.entries(key.name).empty());
  return configuration.isGiven(key.name) && !isEmpty;
}

/// Why a key of a rule has no effect; empty: it has one.
std::string reasonOf(const Rule& rule, const Configuration& configuration, std::span<const ConfigurationKey> keys) {
  const std::string other = "'" + std::string(rule.other) + "'";
  const auto key = std::ranges::find(keys, rule.other, &ConfigurationKey::name);
  if (rule.working.empty()) {
    return isThere(configuration, *key) ? other + " is given" : "";
  }
  if (rule.working == "given") {
    return isThere(configuration, *key) ? "" : other + " is not given";
  }
  const std::string value = valueOf(configuration, *key);
  return isOneOf(value, rule.working) ? "" : other + " is " + value;
}

}  // namespace

std::vector<core::Diagnostic> idleKeys(std::string_view process, std::string_view configurationJson) {
  std::vector<core::Diagnostic> warnings;
  const ProcessEntry* const entry = findProcess(process);
  const auto configuration = entry != nullptr ? readConfiguration(entry->name, entry->keys, configurationJson)
                                              : tl::expected<Configuration, std::vector<ConfigurationError>>(
                                                    tl::unexpected(std::vector<ConfigurationError>()));
  if (!configuration) {
    return warnings;
  }
  for (const Rule& rule : kRules) {
    if (rule.process != entry->name || !configuration->isGiven(rule.key)) {
      continue;
    }
    if (const std::string reason = reasonOf(rule, *configuration, entry->keys); !reason.empty()) {
      core::Diagnostic warning = wrongConfiguration(
          entry->name, "'" + std::string(rule.key) + "' has no effect, because " + reason,
          rule.working.empty() ? "leave one of them out" : "leave it out, or change '" + std::string(rule.other) + "'");
      warning.severity = core::Severity::Warning;
      warnings.push_back(std::move(warning));
    }
  }
  // environments inside another one
  for (const ConfigurationKey& key : entry->keys) {
    if (key.kind != KeyKind::Entries) {
      continue;
    }
    for (const std::string& text : configuration->entries(key.name)) {
      auto object = parseJson(text, std::string(key.name));
      if (object && object->is_object() && object->contains("type") && (*object)["type"].is_string()) {
        const std::string type = (*object)["type"];
        object->erase("type");
        object->erase("name");
        for (core::Diagnostic& warning : idleKeys(type, object->dump())) {
          warnings.push_back(std::move(warning));
        }
      }
    }
  }
  return warnings;
}

std::vector<std::string> problemsOfIdleKeys() {
  std::vector<std::string> problems;
  for (const Rule& rule : kRules) {
    const std::string name = std::string(rule.process) + ", " + std::string(rule.key) + ": ";
    const ProcessEntry* const entry = findProcess(rule.process);
    if (entry == nullptr || std::ranges::count(entry->keys, rule.key, &ConfigurationKey::name) != 1) {
      problems.push_back(name + "no such key");
      continue;
    }
    const auto other = std::ranges::find(entry->keys, rule.other, &ConfigurationKey::name);
    if (other == entry->keys.end()) {
      problems.push_back(name + "no key " + std::string(rule.other));
    } else if (!rule.working.empty() && rule.working != "given" && other->kind != KeyKind::Boolean &&
               std::ranges::none_of(other->choices, [&](auto value) { return isOneOf(value, rule.working); })) {
      problems.push_back(name + "no value " + std::string(rule.working));
    }
  }
  return problems;
}

}  // namespace espalier::environment
