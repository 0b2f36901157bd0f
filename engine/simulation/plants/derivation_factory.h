#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "engine/derivation/derivation.h"
#include "engine/simulation/forest.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/plant_messages.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// Makes the Derivations of plants: which seed, length, limits and messages each one has. All that it is made from must
/// outlive it and the Derivations.
class DerivationFactory {
 public:
  DerivationFactory(const ModelSet& models, const SimulationOptions& options, const std::atomic<bool>& isCancelled,
                    PlantMessages& messages)
      : models_(&models), options_(&options), isCancelled_(&isCancelled), messages_(&messages) {}

  /// The seed of the run (Simulation::seed).
  [[nodiscard]] std::uint64_t seed() const;
  /// Steps of the whole run.
  [[nodiscard]] std::uint64_t runLength() const;
  [[nodiscard]] derivation::DerivationOptions options(std::uint32_t plant, const Plant& member) const;
  /// Advances the plant.
  [[nodiscard]] std::unique_ptr<derivation::Derivation> forSteps(std::uint32_t plant, const Plant& member) const;
  /// Expands the plant's string for pictures: nothing is printed, and cancelling a step does not stop it.
  [[nodiscard]] std::unique_ptr<derivation::Derivation> forDrawing(std::uint32_t plant, const Plant& member) const;

 private:
  [[nodiscard]] std::optional<std::uint64_t> lengthOf(const Plant& member) const;

  const ModelSet* models_;
  const SimulationOptions* options_;
  const std::atomic<bool>* isCancelled_;
  PlantMessages* messages_;
};

}  // namespace espalier::simulation
