#include "engine/simulation/plants/world_variables.h"

#include <algorithm>
#include <map>

#include "engine/language/world_names.h"
#include "engine/turtle/weather.h"

namespace espalier::simulation {

namespace {

std::optional<double> valueOf(const std::string& name, const turtle::World& world, double from, double to) {
  if (name == "time") {
    return from;
  }
  if (!world.weather) {
    return std::nullopt;
  }
  return name == "thermalTime" ? world.weather->thermalTime(from, world.baseTemperature)
                               : world.weather->mean(name, from, to);
}

double beginOf(const turtle::World& world, std::uint64_t step) {
  return turtle::beginOfStep(world.stepDurationDays, step);
}

}  // namespace

WorldVariables::WorldVariables(const Programs& programs) {
  for (const auto& program : programs) {
    for (const language::LSystem& system : program->systems) {
      for (const std::string& variable : system.variables) {
        if (language::isWorldName(variable)) {
          names_.push_back(variable.substr(language::kWorldPrefix.size()));
        }
      }
    }
  }
  std::sort(names_.begin(), names_.end());
  names_.erase(std::unique(names_.begin(), names_.end()), names_.end());
}

void WorldVariables::set(Population& population, const turtle::World& world, std::uint64_t completedSteps) const {
  if (!isUsed()) {
    return;
  }
  std::map<std::string, double> values;
  for (const std::string& name : names_) {
    if (const auto value = valueOf(name, world, beginOf(world, completedSteps), beginOf(world, completedSteps + 1))) {
      values.emplace(std::string(language::kWorldPrefix) + name, *value);
    }
  }
  for (std::size_t plant = 0; plant < population.size(); ++plant) {
    if (!population.member(plant).isAlive()) {
      continue;
    }
    for (derivation::InstanceState& instance : population.states()[plant].instances) {
      const std::vector<std::string>& variables = population.program(plant).systems[instance.system].variables;
      for (std::size_t slot = 0; slot < variables.size(); ++slot) {
        if (const auto value = values.find(variables[slot]); value != values.end()) {
          instance.variables[slot] = value->second;
        }
      }
    }
  }
}

std::optional<std::string> WorldVariables::problem(const turtle::World& world, std::uint64_t completedSteps) const {
  const double from = beginOf(world, completedSteps);
  const double to = beginOf(world, completedSteps + 1);
  for (const std::string& name : names_) {
    if (!valueOf(name, world, from, to)) {
      return "the model reads 'world." + name + "' and " +
             turtle::missingWeather(world, name == "thermalTime" ? "temperature" : name, from, to);
    }
  }
  return std::nullopt;
}

}  // namespace espalier::simulation
