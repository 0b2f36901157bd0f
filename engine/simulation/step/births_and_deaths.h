#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/derivation/derivation.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/population.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/step/seed_bed.h"
#include "engine/simulation/step/step_transaction.h"

namespace espalier::simulation {

/// The seeds and the deaths of the step under way: the queries of ?Seed and ?Death, the seeds that take root, and the
/// plants that come and go when the step is complete.
class BirthsAndDeaths {
 public:
  /// Takes the queries of ?Seed and ?Death out of the batch, and their `offsets`; the environment sees the rest.
  /// Decides which seeds take root. Throws SimulationFailure for a seed of a model that does not exist.
  void takeQueries(const ModelSet& models, const Population& population, const SimulationOptions& options,
                   std::uint64_t runSeed, std::uint64_t completedSteps, turtle::QueryBatch& queries,
                   std::vector<std::uint64_t>& offsets);
  /// Writes what became of each seed into the mothers' strings. Returns the number of answers.
  std::uint64_t writeReplies(std::vector<derivation::PlantState>& states, StepTransaction& transaction) const;

  [[nodiscard]] bool hasSeeds() const { return !seeds_.empty(); }
  [[nodiscard]] bool hasDeaths() const { return !dying_.empty(); }
  [[nodiscard]] bool isDying(std::size_t plant) const;

  /// A plant that took root in this step, not yet a part of the population.
  struct Seedling {
    Plant member;
    derivation::PlantState state;
    std::unique_ptr<derivation::Derivation> derivation;
  };
  /// Starts a plant with its axiom for each seed that took root.
  void growSeedlings(const Population& population, const DerivationFactory& factory, std::uint64_t completedSteps);
  [[nodiscard]] std::vector<Seedling>& seedlings() { return seedlings_; }

  /// The step is complete: plants end, seedlings become plants. Counts both.
  void complete(Population& population, StepTransaction& transaction, std::uint64_t completedSteps,
                StepStatistics& statistics);
  /// The step is not made, or begins again.
  void clear();

 private:
  std::vector<Seed> seeds_;
  std::vector<std::uint32_t> dying_;  // plants that end in the step, rising
  std::vector<Seedling> seedlings_;
};

}  // namespace espalier::simulation
