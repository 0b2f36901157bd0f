#include "server/remote/terrain/terrain_embedding.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/core/vec3.h"
#include "environment/base/published_text.h"
#include "environment/output/file_embedding.h"
#include "environment/registry.h"

namespace espalier::server {

namespace {

using nlohmann::json;

/// How heights come into the world: (east, height, −north) of (place − origin) · scale.
struct TerrainPlacement {
  std::array<double, 3> origin{};  // east, north, height
  bool hasOrigin = false;          // as a key
  double scale = 1.0;
};

bool isNumber(const json& value) {
  return value.is_number() && std::abs(value.get<double>()) < 1e100;
}

/// Takes the keys beside `terrainFile` out of a configuration; a sentence when one is wrong.
std::optional<std::string> takeKeys(json& configuration, TerrainPlacement& placement) {
  if (const auto origin = configuration.find("terrainOrigin"); origin != configuration.end()) {
    if (!origin->is_array() || origin->size() != 3 || !std::ranges::all_of(*origin, isNumber)) {
      return std::string("'terrainOrigin' must be three numbers: east, north, height");
    }
    placement.origin = origin->get<std::array<double, 3>>();
    placement.hasOrigin = true;
    configuration.erase(origin);
  }
  if (const auto scale = configuration.find("terrainScale"); scale != configuration.end()) {
    if (!isNumber(*scale) || !(scale->get<double>() > 0.0)) {
      return std::string("'terrainScale' must be a number above 0");
    }
    placement.scale = scale->get<double>();
    configuration.erase(scale);
  }
  return std::nullopt;
}

/// A sentence when a ground without `terrainOrigin` is farther from the plants than it is large.
std::optional<std::string> problemOfPlace(const Terrain& terrain) {
  const double width = terrain.east() - terrain.west;
  const double depth = terrain.north - terrain.south();
  const double east = std::max({0.0, terrain.west, -terrain.east()});
  const double north = std::max({0.0, terrain.south(), -terrain.north});
  const double distance = core::length({east, north, 0.0});
  if (distance <= core::length({width, depth, 0.0})) {
    return std::nullopt;
  }
  const auto whole = [](double place) { return std::to_string(std::llround(std::clamp(place, -1e15, 1e15))); };
  return "it lies " + whole(distance) +
         " from the origin of the world. Set 'terrainOrigin' to the east, north and height of a place in it, or to "
         "[0, 0, 0] if the plants have such coordinates too: its "
         "middle is [" +
         whole(terrain.west + 0.5 * width) + ", " + whole(terrain.south() + 0.5 * depth) + ", " +
         whole(terrain.heights[(terrain.rows / 2) * terrain.columns + terrain.columns / 2]) + "]";
}

bool takesHeights(const std::string& type) {
  const environment::ProcessEntry* const process = environment::findProcess(type);
  return process != nullptr && std::ranges::any_of(process->keys, [](const environment::ConfigurationKey& key) {
           return key.name == "heightField";
         });
}

}  // namespace

std::optional<core::Diagnostic> embedTerrainFile(environment::EnvironmentEntry& entry, const std::string& file,
                                                 core::FileProvider& files) {
  json configuration = json::parse(entry.configuration, nullptr, false);
  const auto named = configuration.is_object() ? configuration.find("terrainFile") : configuration.end();
  if (!configuration.is_object() || named == configuration.end() || !named->is_string()) {
    return std::nullopt;
  }
  const std::string name = environment::besideFile(file, named->get<std::string>());
  const auto failed = [&](const std::string& message) {
    core::Diagnostic diagnostic;
    diagnostic.message = file + ": the terrain file '" + name + "' of the environment '" + entry.name + "': " + message;
    diagnostic.hint = "a GeoTIFF of heights (.tif), looked for beside the configuration";
    return diagnostic;
  };
  TerrainPlacement placement;
  if (const auto problem = takeKeys(configuration, placement)) {
    return failed(*problem);
  }
  if (!takesHeights(entry.type)) {
    return failed("the environment '" + entry.type + "' takes no ground. Give it to one with obstacles");
  }
  for (const char* key : {"heightField", "heightFieldExtent"}) {
    if (configuration.contains(key)) {
      return failed("the configuration has '" + std::string(key) + "' too. Leave one of them out");
    }
  }
  const auto bytes = files.read(name);
  if (!bytes) {
    return failed("it cannot be read");
  }
  const auto terrain = readGeoTiff(*bytes);
  if (!terrain) {
    return failed("it " + terrain.error());
  }
  if (const auto problem = placement.hasOrigin ? std::nullopt : problemOfPlace(*terrain)) {
    return failed(*problem);
  }
  configuration.erase("terrainFile");
  const auto east = [&](double place) { return (place - placement.origin[0]) * placement.scale; };
  const auto south = [&](double place) { return (placement.origin[1] - place) * placement.scale; };
  configuration["heightFieldExtent"] = {east(terrain->west), south(terrain->north), east(terrain->east()),
                                        south(terrain->south())};
  // the row with the largest z, which is the southern one, comes first
  json& rows = configuration["heightField"] = json::array();
  for (std::size_t row = terrain->rows; row-- > 0;) {
    json& heights = rows.emplace_back(json::array());
    for (std::size_t column = 0; column < terrain->columns; ++column) {
      heights.push_back((terrain->heights[row * terrain->columns + column] - placement.origin[2]) * placement.scale);
    }
  }
  entry.configuration = configuration.dump();
  return std::nullopt;
}

std::optional<core::Diagnostic> embedAllFiles(environment::EnvironmentEntry& entry, const std::string& file,
                                              core::FileProvider& files) {
  auto problem = embedTerrainFile(entry, file, files);
  return problem ? problem : environment::embedFiles(entry, file, files);
}

turtle::Field heightsOf(const Terrain& terrain) {
  turtle::Field field;
  field.name = "height";
  field.unit = terrain.lengthUnit.empty() ? "length" : terrain.lengthUnit;
  field.cells = {terrain.columns, terrain.rows, 1};
  field.cellSize = {terrain.eastStep, terrain.southStep, 1.0};
  field.position = {terrain.west - 0.5 * terrain.eastStep, terrain.south() - 0.5 * terrain.southStep, 0.0};
  for (std::size_t row = terrain.rows; row-- > 0;) {
    const auto from = terrain.heights.begin() + static_cast<std::ptrdiff_t>(row * terrain.columns);
    field.values.insert(field.values.end(), from, from + static_cast<std::ptrdiff_t>(terrain.columns));
  }
  return field;
}

}  // namespace espalier::server
