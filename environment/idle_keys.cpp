#include "environment/idle_keys.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "environment/base/configuration.h"
#include "environment/base/json_text.h"
#include "environment/base/number_text.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

/// When a key has no effect.
struct Rule {
  std::string_view process;
  std::string_view key;
  std::string_view other;  // several with a bar between them: the key works while it does by one of them
  /// The key works while `other` is one of these, with a bar between them; "given": while it is given and does
  /// something; empty: while not.
  std::string_view working;
};

constexpr Rule kRules[]{
    {"soil-water", "topHead", "surface", "head"},
    {"soil-water", "rain", "surface", "weather"},
    {"soil-water", "evaporation", "surface", "weather"},
    {"soil-water", "driestHead", "surface", "weather"},
    {"soil-water", "weatherPeriod", "rain|evaporation|groundLight", "given"},
    {"soil-water", "bottomHead", "bottom", "head"},
    {"soil-water", "initialHead", "initially", "head"},
    {"soil-water", "initialHead", "initialHeads", ""},
    {"soil-water", "waterTableDepth", "initially", "waterTable"},
    {"soil-water", "waterTableDepth", "initialHeads", ""},
    {"soil-water", "roughness", "evaporationBy", "weather"},
    {"soil-water", "windHeight", "evaporationBy", "weather"},
    {"soil-water", "albedo", "evaporationBy", "weather"},
    {"soil-water", "groundLight", "evaporationBy", "weather"},
    {"soil-water", "longWaveLoss", "evaporationBy", "weather"},
    {"soil-water", "airPressure", "evaporationBy", "weather"},
    {"soil-water", "solutesEnter", "solutes|acidity", "given"},
    {"soil-water", "initialPh", "acidity", "true"},
    {"soil-water", "rainPh", "acidity", "true"},
    {"soil-water", "bufferCapacity", "acidity", "true"},
    {"soil-water", "protonDiffusivity", "acidity", "true"},
    {"soil-water", "dispersivity", "acidity", "true"},
    {"soil", "uniformConcentration", "concentration", ""},
    {"soil", "sliceCount", "concentration", "given"},
    {"soil", "diffusionTolerance", "diffusionSteps", "given"},
    {"soil", "relaxationFactor", "diffusionSteps", "given"},
    {"xylem", "transpiration", "collar", "flow"},
    {"xylem", "transpirationPeriod", "transpiration", "given"},
    {"xylem", "dayCourse", "collar", "flow"},
    {"xylem", "lowestHead", "collar", "flow"},
    {"xylem", "collarHead", "collar", "head"},
    {"xylem", "soilHead", "soilHeads", ""},
    {"xylem", "soilHead", "soil", ""},
    {"xylem", "soilHeads", "soil", ""},
    {"xylem", "rhizosphere", "soil", "given"},
    {"xylem", "kr", "krTable", ""},
    {"xylem", "kx", "kxTable", ""},
    {"xylem", "vulnerabilityShape", "vulnerabilityHead", "given"},
    {"xylem", "stomataConductance", "leaves", "stomata"},
    {"xylem", "cuticleConductance", "leaves", "stomata"},
    {"xylem", "halfPar", "leaves", "stomata"},
    {"xylem", "halfDeficit", "leaves", "stomata"},
    {"xylem", "stomataHead", "leaves", "stomata"},
    {"xylem", "stomataShape", "leaves", "stomata"},
    {"xylem", "leafWidth", "leaves", "stomata"},
    {"xylem", "leafWidth", "boundaryConductance", ""},
    {"xylem", "boundaryConductance", "leaves", "stomata"},
    {"xylem", "temperature", "leaves", "stomata"},
    {"xylem", "humidity", "leaves", "stomata"},
    {"xylem", "wind", "leaves", "stomata"},
    {"xylem", "pressure", "leaves", "stomata"},
    {"xylem", "saturationCurve", "leaves", "stomata"},
    {"xylem", "growthHead", "leaves", "stomata"},
    {"wind", "speed", "profile", "constant|logarithmic|power"},
    {"wind", "groundHeight", "profile", "logarithmic|power|table"},
    {"wind", "referenceHeight", "profile", "logarithmic|power"},
    {"wind", "roughness", "profile", "logarithmic"},
    {"wind", "displacement", "profile", "logarithmic"},
    {"wind", "exponent", "profile", "power"},
    {"wind", "heights", "profile", "table"},
    {"wind", "speeds", "profile", "table"},
    {"light", "sunDirection", "sun", "direction"},
    {"light", "sunAzimuths", "sun", "direction"},
    {"light", "directIrradiance", "sun", "direction"},
    {"light", "diffuseIrradiance", "sun", "none|direction"},
    {"light", "start", "sun", "position"},
    {"light", "latitude", "sun", "position"},
    {"light", "longitude", "sun", "position"},
    {"light", "atmosphere", "sun", "position"},
    {"light", "sunSamples", "sun", "position"},
    {"light", "photonsPerJoule", "unit", "umol|mol"},
    {"light", "bounces", "remainder", ""},
    {"light", "groundReflectance", "ground", "true"},
    {"light", "groundHeight", "ground", "true"},
    {"light", "groundCells", "ground", "true"},
    {"light-voxels", "fullLight", "method", "shadow"},
    {"light-voxels", "shadowStrength", "method", "shadow"},
    {"light-voxels", "shadowBase", "method", "shadow"},
    {"light-voxels", "shadowDepth", "method", "shadow"},
    {"light-voxels", "sky", "method", "turbid"},
    {"light-voxels", "sun", "method", "turbid"},
    {"light-voxels", "unit", "method", "turbid"},
    {"light-voxels", "bands", "method", "turbid"},
    {"light-voxels", "directions", "method", "turbid"},
    {"light-voxels", "zenithAngles", "method", "turbid"},
    {"light-voxels", "azimuthAngles", "method", "turbid"},
    {"light-voxels", "irradiance", "method", "turbid"},
    {"light-voxels", "leafAngles", "method", "turbid"},
    {"light-voxels", "absorptance", "method", "turbid"},
    {"light-voxels", "leafAreaDensity", "method", "turbid"},
    {"light-voxels", "ellipsoidRatio", "leafAngles", "ellipsoidal"},
    {"light-voxels", "sky", "directions", ""},
    {"light-voxels", "zenithAngles", "directions", ""},
    {"light-voxels", "azimuthAngles", "directions", ""},
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
    {"light-voxels", "remainder", "scattering", "true"},
    {"chiba", "sampleCount", "sources", ""},
    {"chiba", "lowerToUpperRatio", "sources", ""},
    {"chiba", "overcastSky", "sources", ""},
    {"chiba", "gridSize", "compatible", "true"},
    {"takenaka", "sources", "diskSource", ""},
    {"takenaka", "gridSize", "compatible", "true"},
    {"honda", "plane", "threeDimensional", "false"},
    {"ecosystem", "plane", "threeDimensional", "false"},
    {"density3d", "gridSize", "octreeLevel", ""},
    {"colonization", "markerBox", "markerCount", "given"},
    {"crowding", "asymmetry", "competition", "weighted"},
};

std::string valueOf(const Configuration& configuration, const ConfigurationKey& key) {
  return key.kind == KeyKind::Boolean ? (configuration.flag(key.name) ? "true" : "false")
                                      : configuration.text(key.name);
}

/// Calls `visit` with each of the names that have bars between them, until it returns true; whether it did.
template <typename Visit>
bool anyOf(std::string_view names, const Visit& visit) {
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find('|', begin), names.size());
    if (visit(names.substr(begin, end - begin))) {
      return true;
    }
    begin = end + 1;
  }
  return false;
}

bool isOneOf(std::string_view value, std::string_view working) {
  return anyOf(working, [&](std::string_view one) { return one == value; });
}

/// Whether a key is given and does something: it is no empty list, not false, and no number that is the default.
bool isThere(const Configuration& configuration, const ConfigurationKey& key) {
  const bool isEmpty =
      (key.kind == KeyKind::Boolean && !configuration.flag(key.name)) ||
      (key.kind == KeyKind::Number && configuration.number(key.name) == key.defaultNumber) ||
      (key.kind == KeyKind::Integer && static_cast<double>(configuration.integer(key.name)) == key.defaultNumber) ||
      (key.kind == KeyKind::Rows && configuration.rows(key.name).empty()) ||
      (key.kind == KeyKind::Numbers && configuration.numbers(key.name).empty()) ||
      (key.kind == KeyKind::Entries && configuration.entries(key.name).empty());
  return configuration.isGiven(key.name) && !isEmpty;
}

/// The names of a rule's `other` as text: "'rain' and 'evaporation'".
std::string quoted(std::string_view names) {
  std::string text;
  anyOf(names, [&](std::string_view name) {
    text += (text.empty() ? "'" : " and '") + std::string(name) + "'";
    return false;
  });
  return text;
}

/// Why a key of a rule has no effect; empty: it has one.
std::string reasonOf(const Rule& rule, const Configuration& configuration, std::span<const ConfigurationKey> keys) {
  const std::string other = quoted(rule.other);
  const auto isOneThere = [&] {
    return anyOf(rule.other, [&](std::string_view name) {
      return isThere(configuration, *std::ranges::find(keys, name, &ConfigurationKey::name));
    });
  };
  if (rule.working.empty()) {
    return isOneThere() ? other + " is given" : "";
  }
  if (rule.working == "given") {
    return isOneThere() ? "" : other + (rule.other.find('|') == std::string_view::npos ? " is" : " are") + " not given";
  }
  const std::string value = valueOf(configuration, *std::ranges::find(keys, rule.other, &ConfigurationKey::name));
  return isOneOf(value, rule.working) ? "" : other + " is " + value;
}

/// The sum of the parts of the light in bands, when it is above 1 and not because each band has all of it; else 0.
double surplusOfBands(const Configuration& configuration, std::span<const ConfigurationKey> keys) {
  if (std::ranges::find(keys, "bands", &ConfigurationKey::name) == keys.end()) {
    return 0.0;
  }
  const std::vector<double>& bands = configuration.numbers("bands");
  const double sum = std::accumulate(bands.begin(), bands.end(), 0.0);
  const bool isEachAll = std::ranges::all_of(bands, [](double part) { return part == 1.0; });
  return sum > 1.0 + 1e-6 && !isEachAll ? sum : 0.0;
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
  std::vector<std::string_view> idle;  // one reason for each
  for (const Rule& rule : kRules) {
    if (rule.process != entry->name || !configuration->isGiven(rule.key) ||
        std::ranges::find(idle, rule.key) != idle.end()) {
      continue;
    }
    if (const std::string reason = reasonOf(rule, *configuration, entry->keys); !reason.empty()) {
      idle.push_back(rule.key);
      core::Diagnostic warning = wrongConfiguration(
          entry->name, "'" + std::string(rule.key) + "' has no effect, because " + reason,
          rule.working.empty() ? "leave one of them out" : "leave it out, or change " + quoted(rule.other));
      warning.severity = core::Severity::Warning;
      warnings.push_back(std::move(warning));
    }
  }
  if (const double sum = surplusOfBands(*configuration, entry->keys); sum > 0.0) {
    warnings.push_back(
        wrongConfiguration(entry->name, "'bands' are parts of the irradiance and add up to " + numberText(sum),
                           "write parts that add up to 1 or less, or 1 for each band: then each has all of the light"));
    warnings.back().severity = core::Severity::Warning;
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
    anyOf(rule.other, [&](std::string_view otherName) {
      const auto other = std::ranges::find(entry->keys, otherName, &ConfigurationKey::name);
      if (other == entry->keys.end()) {
        problems.push_back(name + "no key " + std::string(otherName));
      } else if (!rule.working.empty() && rule.working != "given" && other->kind != KeyKind::Boolean &&
                 std::ranges::none_of(other->choices, [&](auto value) { return isOneOf(value, rule.working); })) {
        problems.push_back(name + "no value " + std::string(rule.working));
      }
      return false;
    });
  }
  return problems;
}

}  // namespace espalier::environment
