#include "environment/output/field_embedding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "environment/base/published_text.h"
#include "environment/output/field_output.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

/// The field that a process takes from a file.
struct FieldUse {
  std::string_view process;
  std::string_view field;
  std::string_view key;
  bool hasCubes;  // the process has a voxelSize instead of a cellSize
};
constexpr std::array kUses{FieldUse{"soil-water", "pressureHead", "initialHeads", false},
                           FieldUse{"light-voxels", "leafAreaDensity", "leafAreaDensity", true}};

tl::expected<std::vector<turtle::Field>, std::string> readFields(const std::string& name, core::FileProvider& files) {
  const auto bytes = files.read(name);
  if (!bytes) {
    return tl::unexpected(std::string("it cannot be read"));
  }
  if (!name.ends_with(".raw")) {
    return readVti(*bytes).map_error([](const std::string& problem) { return "it " + problem; });
  }
  const auto header = files.read(name + ".json");
  if (!header) {
    return tl::unexpected("there is no header '" + name + ".json' beside it");
  }
  auto read = readRaw(*header, *bytes);
  if (!read) {
    return tl::unexpected("it " + read.error());
  }
  return std::vector{std::move(*read)};
}

/// The field of this name, of one environment or of several (NAME.QUANTITY).
const turtle::Field* find(const std::vector<turtle::Field>& fields, std::string_view name) {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const turtle::Field& field) {
    return field.name == name || field.name.ends_with("." + std::string(name));
  });
  return found == fields.end() ? nullptr : &*found;
}

/// The unit of a field as keys have it, "cm" or "1/cm"; empty when the file names none.
std::string unitOf(const turtle::Field& field) {
  std::string_view unit = field.unit;
  if (unit == "1" || unit == "1/length") {
    return "";
  }
  for (const std::string_view power : {"^-1", "-1"}) {
    if (unit.ends_with(power)) {
      return "1/" + std::string(unit.substr(0, unit.size() - power.size()));
    }
  }
  return std::string(unit);
}

/// Sets a key, or says that the entry has another value there. Lengths may differ by the rounding of a file.
std::string setOrRefuse(nlohmann::json& configuration, const std::string& key, const nlohmann::json& value) {
  const auto own = configuration.find(key);
  if (own == configuration.end()) {
    configuration[key] = value;
    return "";
  }
  const auto isNear = [](const nlohmann::json& a, const nlohmann::json& b) {
    return a.is_number() && b.is_number() &&
           std::abs(a.get<double>() - b.get<double>()) <= 1e-9 * (1.0 + std::abs(b.get<double>()));
  };
  bool isSame = isNear(*own, value) || *own == value;
  if (own->is_array() && value.is_array() && own->size() == value.size()) {
    isSame = std::equal(own->begin(), own->end(), value.begin(), isNear);
  }
  return isSame ? "" : "its '" + key + "' is " + value.dump() + ", and the configuration has " + own->dump();
}

}  // namespace

std::optional<core::Diagnostic> embedFieldFile(EnvironmentEntry& entry, const std::string& file,
                                               core::FileProvider& files) {
  nlohmann::json configuration = nlohmann::json::parse(entry.configuration, nullptr, false);
  const auto named = configuration.is_object() ? configuration.find("fieldFile") : configuration.end();
  const std::string type = canonicalName(entry.type);
  const auto use = std::find_if(kUses.begin(), kUses.end(), [&](const FieldUse& one) { return one.process == type; });
  if (!configuration.is_object() || named == configuration.end() || !named->is_string() || use == kUses.end()) {
    return std::nullopt;
  }
  const std::string name = besideFile(file, named->get<std::string>());
  const auto failed = [&](const std::string& message, const std::string& hint) {
    core::Diagnostic diagnostic;
    diagnostic.message = file + ": the field file '" + name + "' of the environment '" + entry.name + "': " + message;
    diagnostic.hint = hint;
    return diagnostic;
  };
  const auto read = readFields(name, files);
  if (!read) {
    return failed(read.error(), "a .vti or .raw file as --field writes it, looked for beside the configuration");
  }
  const turtle::Field* field = find(*read, use->field);
  if (field == nullptr) {
    return failed("it has no field '" + std::string(use->field) + "'",
                  "'" + type + "' begins with that field; `espalier field FILE` lists the fields of a file");
  }
  configuration.erase(named);
  std::vector<std::pair<std::string, nlohmann::json>> box{
      {"gridSize", {field->cells[0], field->cells[1], field->cells[2]}},
      {"position", {field->position.x, field->position.y, field->position.z}}};
  if (use->hasCubes) {
    box.emplace_back("voxelSize", field->cellSize.x);
  } else {
    box.emplace_back("cellSize", nlohmann::json{field->cellSize.x, field->cellSize.y, field->cellSize.z});
  }
  if (const std::string unit = unitOf(*field); !unit.empty()) {
    box.emplace_back("fieldUnit", unit);
  }
  for (const auto& [key, value] : box) {
    if (const std::string problem = setOrRefuse(configuration, key, value); !problem.empty()) {
      return failed(problem, "leave '" + key + "' out: the file brings it");
    }
  }
  configuration[std::string(use->key)] = field->values;
  entry.configuration = configuration.dump();
  return std::nullopt;
}

}  // namespace espalier::environment
