#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/simulation/plants/plant_messages.h"
#include "engine/simulation/plants/population.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/step/module_ages.h"
#include "engine/simulation/step/production_log.h"
#include "engine/simulation/step/step_transaction.h"

namespace espalier::simulation {

/// The second half of a step: derives plants, small ones side by side. Results, messages and the first failure are
/// those of one plant after the other. Everything that it is made from must outlive it.
class DerivationPass {
 public:
  DerivationPass(const SimulationOptions& options, PlantMessages& messages, Population& population,
                 StepTransaction& transaction, ProductionLog& productions, ModuleAges& ages)
      : options_(&options),
        messages_(&messages),
        population_(&population),
        transaction_(&transaction),
        productions_(&productions),
        ages_(&ages) {}

  /// Derives these plants, by rising number. `isKept`: each one is copied before, so that it can be taken back when
  /// another fails. `isFollowed`: the transaction learns what changes. Throws SimulationFailure.
  void run(const std::vector<std::size_t>& plants, bool isKept, bool isFollowed, std::uint64_t completedSteps);

 private:
  void deriveSideBySide(const std::vector<std::size_t>& plants);
  void derivePlant(std::size_t plant);
  /// Throws when so many modules and bytes are more than all strings of a simulation may have.
  void requireTogether(std::uint64_t modules, std::uint64_t bytes) const;
  [[nodiscard]] bool isWorthThreads(const std::vector<std::size_t>& plants) const;
  [[nodiscard]] bool isLong(std::size_t plant) const;
  [[nodiscard]] unsigned threadCount() const;

  const SimulationOptions* options_;
  PlantMessages* messages_;
  Population* population_;
  StepTransaction* transaction_;
  ProductionLog* productions_;
  ModuleAges* ages_;
  // of the pass under way
  bool isKept_ = false;
  bool isFollowed_ = false;
  std::uint64_t completedSteps_ = 0;
  std::atomic<std::uint64_t> derivedModules_{0};  // of the plants that were derived so far
  std::atomic<std::uint64_t> derivedBytes_{0};

  std::unique_ptr<core::WorkerTeam> team_;  // null: not needed yet
};

}  // namespace espalier::simulation
