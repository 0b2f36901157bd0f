#include "environment/output/point_embedding.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "engine/core/hash.h"
#include "environment/base/published_text.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

using nlohmann::json;

/// Each is a row of numbers in the configuration that is sent to the process.
constexpr std::size_t kMostRows = 1'000'000;

/// The keys beside `pointFile`, taken out of the configuration.
struct PointKeys {
  PointPlacement placement;
  bool hasOrigin = false;
  double spacing = 0.0;
  double radius = 0.0;
  double strength = 1.0;
  std::vector<double> classes;  // empty: all
};

/// Takes a key of numbers; a sentence when it is not `count` of them (0: any number).
std::optional<std::string> takeNumbers(json& configuration, const char* key, std::size_t count,
                                       std::vector<double>& numbers) {
  const auto found = configuration.find(key);
  if (found == configuration.end()) {
    return std::nullopt;
  }
  const json list = found->is_array() ? *found : json::array({*found});
  const bool isRight = (count == 0 ? !list.empty() : list.size() == count) &&
                       std::all_of(list.begin(), list.end(), [](const json& each) {
                         return each.is_number() && std::abs(each.get<double>()) < 1e100;
                       });
  if (!isRight) {
    return "'" + std::string(key) + "' must be " +
           (count == 1   ? "a number"
            : count == 0 ? "a list of numbers"
                         : "three numbers");
  }
  numbers.clear();
  for (const json& each : list) {
    numbers.push_back(each.get<double>());
  }
  configuration.erase(found);
  return std::nullopt;
}

std::optional<std::string> takeKeys(json& configuration, PointKeys& keys) {
  std::vector<double> origin{0.0, 0.0, 0.0};
  keys.hasOrigin = configuration.contains("pointOrigin");
  if (auto problem = takeNumbers(configuration, "pointOrigin", 3, origin)) {
    return problem;
  }
  keys.placement.origin = {origin[0], origin[1], origin[2]};
  for (const auto& [name, target, isAboveZero] : {std::tuple{"pointScale", &keys.placement.scale, true},
                                                  {"pointSpacing", &keys.spacing, true},
                                                  {"pointRadius", &keys.radius, true},
                                                  {"pointStrength", &keys.strength, false}}) {
    std::vector<double> number;
    if (auto problem = takeNumbers(configuration, name, 1, number)) {
      return problem;
    }
    if (!number.empty()) {
      *target = number[0];
      if (isAboveZero && !(*target > 0.0)) {
        return "'" + std::string(name) + "' must be above 0";
      }
    }
  }
  if (auto problem = takeNumbers(configuration, "pointClasses", 0, keys.classes)) {
    return problem;
  }
  if (const auto axes = configuration.find("pointAxes"); axes != configuration.end()) {
    if (*axes != "world" && *axes != "file") {
      return "'pointAxes' must be \"world\" or \"file\"";
    }
    keys.placement.keepsAxes = *axes == "file";
    configuration.erase(axes);
  }
  return std::nullopt;
}

/// The first point in each cube of a side, in their order.
std::vector<core::Vec3> thinned(const std::vector<core::Vec3>& points, double spacing) {
  struct Hash {
    std::size_t operator()(const std::array<double, 3>& cube) const {
      core::Hasher hasher;
      for (const double number : cube) {
        hasher.number(number + 0.0);  // -0 and 0 are equal
      }
      return hasher.value();
    }
  };
  std::unordered_set<std::array<double, 3>, Hash> taken;
  std::vector<core::Vec3> kept;
  for (const core::Vec3& p : points) {
    if (taken.insert({std::floor(p.x / spacing), std::floor(p.y / spacing), std::floor(p.z / spacing)}).second) {
      kept.push_back(p);
    }
  }
  return kept;
}

/// A sentence when points without `pointOrigin` are farther from the plants than they are from each other.
std::optional<std::string> problemOfPlace(const std::vector<core::Vec3>& points) {
  core::Vec3 low = points.front();
  core::Vec3 high = points.front();
  for (const core::Vec3& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const core::Vec3 nearest{std::max({0.0, low.x, -high.x}), std::max({0.0, low.y, -high.y}),
                           std::max({0.0, low.z, -high.z})};
  // coordinates of a projection; a single tree may well stand beside the plants
  constexpr double kFar = 100.0;
  if (core::length(nearest) <= std::max(1.0, core::length(high - low)) * kFar) {
    return std::nullopt;
  }
  const auto whole = [](double place) { return std::to_string(std::llround(std::clamp(place, -1e15, 1e15))); };
  const core::Vec3 middle = (low + high) * 0.5;
  return "its points lie " + whole(core::length(nearest)) +
         " from the origin of the world. Set 'pointOrigin' to a place among them, or to [0, 0, 0] if the plants have "
         "such "
         "coordinates too: their middle is [" +
         whole(middle.x) + ", " + whole(middle.y) + ", " + whole(middle.z) + "]";
}

/// The key of a process that takes points, and the number behind a place in its rows; empty: it has none.
struct PointTarget {
  const char* key = "";
  std::optional<double> number;
};

PointTarget targetOf(const std::string& type, const PointKeys& keys) {
  const ProcessEntry* const process = findProcess(type);
  if (process == nullptr) {
    return {};
  }
  if (process->name == "attractors") {
    return {"points", keys.strength};
  }
  if (process->name == "colonization") {
    return {"points", std::nullopt};
  }
  const bool hasSpheres =
      std::ranges::any_of(process->keys, [](const ConfigurationKey& key) { return key.name == "spheres"; });
  return hasSpheres ? PointTarget{"spheres", keys.radius} : PointTarget{};
}

/// Puts the points into a configuration; a sentence when they cannot be.
std::optional<std::string> putPoints(json& configuration, const std::string& type, const PointKeys& keys,
                                     files::PointCloud cloud) {
  if (!keys.classes.empty()) {
    if (cloud.classes.empty()) {
      return std::string("it has no classes, so 'pointClasses' cannot choose");
    }
    std::vector<core::Vec3> chosen;
    for (std::size_t i = 0; i < cloud.points.size(); ++i) {
      if (std::ranges::find(keys.classes, static_cast<double>(cloud.classes[i])) != keys.classes.end()) {
        chosen.push_back(cloud.points[i]);
      }
    }
    cloud.points = std::move(chosen);
  }
  if (!keys.hasOrigin && !cloud.points.empty()) {
    if (const auto problem = problemOfPlace(cloud.points)) {
      return problem;
    }
  }
  placePoints(cloud, keys.placement);
  const std::vector<core::Vec3> points =
      keys.spacing > 0.0 ? thinned(cloud.points, keys.spacing) : std::move(cloud.points);
  if (points.empty()) {
    return std::string("no point is left. Choose other classes, or another file");
  }
  if (points.size() > kMostRows) {
    return "it gives " + std::to_string(points.size()) + " points, more than " + std::to_string(kMostRows) +
           ". Set 'pointSpacing' to keep one point in each cube";
  }
  const PointTarget target = targetOf(type, keys);
  if (*target.key == '\0') {
    return "the environment '" + type +
           "' takes no points. Give them to one with obstacles, to attractors or to colonization";
  }
  if (target.number == 0.0 && keys.radius == 0.0 && std::string_view(target.key) == "spheres") {
    return std::string("points are solid with a radius. Set 'pointRadius', a length");
  }
  if (configuration.contains(target.key)) {
    return "the configuration has '" + std::string(target.key) + "' too. Leave one of them out";
  }
  json& rows = configuration[target.key] = json::array();
  for (const core::Vec3& point : points) {
    rows.push_back({point.x, point.y, point.z});
    if (target.number) {
      rows.back().push_back(*target.number);
    }
  }
  return std::nullopt;
}

}  // namespace

void placePoints(files::PointCloud& cloud, const PointPlacement& placement) {
  for (core::Vec3& point : cloud.points) {
    point = (point - placement.origin) * placement.scale;
    if (cloud.isNorthEastUp && !placement.keepsAxes) {
      point = {point.x, point.z, -point.y + 0.0};
    }
  }
}

std::optional<core::Diagnostic> embedPointFile(EnvironmentEntry& entry, const std::string& file,
                                               core::FileProvider& files) {
  json configuration = json::parse(entry.configuration, nullptr, false);
  const auto named = configuration.is_object() ? configuration.find("pointFile") : configuration.end();
  if (!configuration.is_object() || named == configuration.end() || !named->is_string()) {
    return std::nullopt;
  }
  const std::string name = besideFile(file, named->get<std::string>());
  const auto failed = [&](const std::string& message) {
    core::Diagnostic diagnostic;
    diagnostic.message = file + ": the point file '" + name + "' of the environment '" + entry.name + "': " + message;
    diagnostic.hint = "a .las or .ply file, looked for beside the configuration";
    return diagnostic;
  };
  PointKeys keys;
  if (const auto problem = takeKeys(configuration, keys)) {
    return failed(*problem);
  }
  const auto bytes = files.read(name);
  if (!bytes) {
    return failed("it cannot be read");
  }
  auto cloud = files::readPoints(*bytes);
  if (!cloud) {
    return failed("it " + cloud.error());
  }
  configuration.erase("pointFile");
  if (const auto problem = putPoints(configuration, entry.type, keys, std::move(*cloud))) {
    return failed(*problem);
  }
  entry.configuration = configuration.dump();
  return std::nullopt;
}

}  // namespace espalier::environment
