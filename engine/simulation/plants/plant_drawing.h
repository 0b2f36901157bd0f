#pragma once

#include <memory>
#include <vector>

#include "engine/derivation/derivation.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/simulation/forest.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/derivation_factory.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// Draws plants as they are, for pictures and streams. Drawing changes nothing: what the blocks of a homomorphism do to
/// variables is taken back. Everything that it is made from must outlive it.
class PlantDrawing {
 public:
  PlantDrawing(const ModelSet& models, const SimulationOptions& options, const DerivationFactory& factory)
      : models_(&models), options_(&options), factory_(&factory) {}

  /// All living plants into one output, in the common numbers of symbols, surfaces, contours and colours. `members` and
  /// `states` are by plant number. Throws SimulationFailure.
  void draw(const std::vector<Plant>& members, std::vector<derivation::PlantState>& states,
            turtle::InterpretationOutput output);
  /// The turtle records of all plants as a chain. `base` is an earlier chain of these plants, or null. `changes` are
  /// those of the strings since, by plant. Throws SimulationFailure.
  void chainRecords(const std::vector<Plant>& members, std::vector<derivation::PlantState>& states,
                    const turtle::RecordChain* base, const std::vector<derivation::StepChanges>& changes,
                    turtle::RecordChain& chain);
  /// The options have changed.
  void forget() { derivations_.clear(); }

 private:
  struct Expansion {
    std::uint64_t birthStep = 0;  // of the plant that it was made for
    std::unique_ptr<derivation::Derivation> derivation;
  };

  void drawPlant(std::size_t plant, const PlantOrigin& origin, derivation::Derivation& derivation,
                 derivation::PlantState& state, const turtle::InterpretationOutput& output);
  /// Expands the plant's string; made when it is first needed. Null: the plant is dead.
  [[nodiscard]] derivation::Derivation* derivationOf(const std::vector<Plant>& members, std::size_t plant);

  const ModelSet* models_;
  const SimulationOptions* options_;
  const DerivationFactory* factory_;
  std::vector<Expansion> derivations_;  // by plant number
};

}  // namespace espalier::simulation
