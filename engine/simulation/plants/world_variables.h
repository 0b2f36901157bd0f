#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/plants/population.h"
#include "engine/turtle/world.h"

namespace espalier::simulation {

/// The variables `world.NAME` of models: hidden variables of their L-systems, which hold the means over the coming
/// step.
class WorldVariables {
 public:
  explicit WorldVariables(const Programs& programs);

  /// Whether a model reads its world.
  [[nodiscard]] bool isUsed() const { return !names_.empty(); }
  /// Gives every living plant the values of the step that comes after so many. Values that are not known stay.
  void set(Population& population, const turtle::World& world, std::uint64_t completedSteps) const;
  /// Why the values of that step are not known: a sentence with a remedy. Nothing: they are.
  [[nodiscard]] std::optional<std::string> problem(const turtle::World& world, std::uint64_t completedSteps) const;

 private:
  std::vector<std::string> names_;  // that some model reads, without `world.`
};

}  // namespace espalier::simulation
