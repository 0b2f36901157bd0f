#pragma once

#include <atomic>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/derivation_factory.h"
#include "engine/simulation/plants/plant_drawing.h"
#include "engine/simulation/plants/plant_messages.h"
#include "engine/simulation/plants/population.h"
#include "engine/simulation/plants/world_variables.h"
#include "engine/simulation/plants_view.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot_content.h"
#include "engine/simulation/step/answer_pass.h"
#include "engine/simulation/step/births_and_deaths.h"
#include "engine/simulation/step/change_log.h"
#include "engine/simulation/step/derivation_pass.h"
#include "engine/simulation/step/environment_link.h"
#include "engine/simulation/step/module_ages.h"
#include "engine/simulation/step/production_log.h"
#include "engine/simulation/step/step_transaction.h"

namespace espalier::simulation {

/// Simulation, made of its parts. stepping.cpp: starting, and the outline of a step; persistence.cpp: hash, save,
/// restore; simulation.cpp: the public interface.
class Simulation::Implementation {
 public:
  using Outcome = std::optional<core::SimulationError>;

  Implementation(Programs programs, std::vector<PlantOrigin> plants,
                 std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options);

  [[nodiscard]] Outcome rewind();
  [[nodiscard]] Outcome rewind(std::uint64_t seed);
  [[nodiscard]] Outcome step();
  [[nodiscard]] Outcome answer();
  [[nodiscard]] Outcome draw(turtle::InterpretationOutput output);
  [[nodiscard]] std::shared_ptr<const PlantsView> takeView();
  void followChanges(bool isWanted) { changes_.follow(ChangeReader::Views, isWanted); }
  void countProductions(bool isWanted) { productions_.follow(isWanted, completedSteps_); }
  [[nodiscard]] std::shared_ptr<const ProductionUses> productionUses() const { return productions_.uses(); }
  void followAges(bool isWanted) { ages_.follow(isWanted, population_.states()); }
  [[nodiscard]] const ModuleAges& ages() const { return ages_; }
  [[nodiscard]] std::uint64_t stateHash() const;
  [[nodiscard]] std::uint64_t plantsHash() const;
  void save(core::ByteSink& sink) const;
  [[nodiscard]] Outcome restore(std::string_view snapshot);
  void setCancelled(bool isCancelled) { isCancelled_.store(isCancelled, std::memory_order_relaxed); }

  [[nodiscard]] const ModelSet& models() const { return models_; }
  [[nodiscard]] const SimulationOptions& options() const { return options_; }
  [[nodiscard]] const DerivationFactory& derivations() const { return derivations_; }
  [[nodiscard]] const Population& population() const { return population_; }
  [[nodiscard]] const StepTransaction& transaction() const { return transaction_; }
  [[nodiscard]] const EnvironmentLink& environment() const { return environment_; }
  [[nodiscard]] const StepStatistics& statistics() const { return statistics_; }
  [[nodiscard]] std::uint64_t keptBytes() const { return answerPass_.bytes() + productions_.bytes(); }
  [[nodiscard]] std::uint64_t completedSteps() const { return completedSteps_; }

 private:
  /// Everything of a run that a snapshot replaces.
  struct Run {
    SimulationOptions options;
    Population population;
    StepTransaction transaction;
    BirthsAndDeaths births{};
    StepStatistics statistics{};
    std::uint64_t completedSteps = 0;
    bool isStarted = false;
    std::string environmentName{};
  };

  // the parts of a step throw SimulationFailure; then undoStep takes them back
  void answerQueries();
  void derivePlants();
  void measureViewVolume();
  void deliverAllFiles();
  void deliverFiles(std::size_t plant, const language::Program& program, derivation::PlantState& state);
  void completeStep();
  void undoStep();
  void noteAnswers();
  /// Runs a part of a step; on a failure of any kind the simulation is as after the last completed step.
  template <typename Part>
  [[nodiscard]] Outcome guarded(Part&& part);

  void begin();
  void startPlant(std::size_t plant, derivation::PlantState& state) const;
  void countStrings();
  [[nodiscard]] turtle::EnvironmentContext environmentContext() const;

  [[nodiscard]] std::string problemOfEnvironment(const SnapshotContent& content) const;
  [[nodiscard]] Run exchangeRun(Run run);
  [[nodiscard]] Outcome resume(SnapshotContent& content);
  void noteRestored(const Run& before);
  [[nodiscard]] std::optional<turtle::EnvironmentError> resumeEnvironment(const SnapshotContent& content,
                                                                          const Run& before);
  /// The error with the step at which the simulation stays.
  [[nodiscard]] core::SimulationError failed(core::SimulationError error) const;

  ModelSet models_;
  SimulationOptions options_;
  std::atomic<bool> isCancelled_{false};
  PlantMessages messages_;
  DerivationFactory derivations_;
  Population population_;
  StepTransaction transaction_;
  ChangeLog changes_;
  ProductionLog productions_;
  ModuleAges ages_;
  std::uint64_t viewNumber_ = 0;                          // of the last view
  std::shared_ptr<const SimulationOptions> viewOptions_;  // of the views; null: they have changed since
  BirthsAndDeaths births_;
  EnvironmentLink environment_;
  PlantDrawing drawing_;
  StepStatistics statistics_;
  WorldVariables worldVariables_;
  AnswerPass answerPass_;
  DerivationPass derivationPass_;
  std::uint64_t completedSteps_ = 0;
  bool isStarted_ = false;
};

}  // namespace espalier::simulation
