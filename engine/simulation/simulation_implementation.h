#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot_content.h"
#include "engine/simulation/step_undo.h"

namespace espalier::simulation {

/// The state and the parts of a step behind Simulation. simulation.cpp: starting, stepping, looking; answering.cpp: the
/// pass that answers queries; persistence.cpp: hash, save, restore.
class Simulation::Implementation {
 public:
  Implementation(std::shared_ptr<const language::Program> program, std::vector<turtle::PlantPlacement> placements,
                 std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options);

  using Outcome = std::optional<core::SimulationError>;

  [[nodiscard]] Outcome rewind();
  [[nodiscard]] Outcome step();
  [[nodiscard]] Outcome answer();
  [[nodiscard]] bool isFinished() const;
  [[nodiscard]] std::uint64_t derivationLength() const;
  [[nodiscard]] derivation::DerivationOptions derivationOptions(std::uint32_t plant) const;
  [[nodiscard]] Outcome draw(turtle::InterpretationOutput output);
  [[nodiscard]] std::uint64_t stateHash() const;
  [[nodiscard]] std::uint64_t plantsHash() const;
  void save(core::ByteSink& sink);
  [[nodiscard]] Outcome restore(std::string_view snapshot);

  std::shared_ptr<const language::Program> program_;
  std::vector<turtle::PlantPlacement> placements_;
  std::unique_ptr<turtle::EnvironmentProcess> environment_;
  SimulationOptions options_;
  turtle::EnvironmentDescription description_;
  std::vector<derivation::PlantState> plants_;
  std::uint64_t completedSteps_ = 0;
  std::uint64_t seed_ = 0;
  StepStatistics statistics_;
  bool isStarted_ = false;
  bool isAnswered_ = false;
  std::atomic<bool> isCancelled_{false};

 private:
  /// Replies of the environment for the step under way: kept when the step fails, forgotten when it is complete.
  struct Pending {
    bool hasReplies = false;
    bool hasTicked = false;
    turtle::ReplyBatch replies;
  };

  [[nodiscard]] bool isCompatible() const { return program_->compatibility != core::Compatibility::Espalier; }
  [[nodiscard]] std::uint64_t effectiveSeed() const;
  void makeDerivations();
  void startFromString(derivation::PlantState& plant) const;
  [[nodiscard]] turtle::EnvironmentContext environmentContext() const;

  // the parts of a step: they throw SimulationFailure and are undone by undoStep
  void answerPass();
  void interpretForQueries();
  void measureGeometry();
  void consultEnvironment();
  void tickEnvironment();
  void exchange();
  void exchangeOnce(std::uint32_t iteration);
  [[nodiscard]] bool hasSettled(const std::vector<double>& sent, const turtle::ReplyBatch& replies) const;
  void rewindPass();
  void requireFiniteReplies() const;
  void writeReplies(const turtle::ReplyBatch& replies);
  void measureViewVolume();
  void derivePass();
  void deliverFiles(std::vector<derivation::PlantState>& plants);
  void completeStep();
  void undoStep();
  [[nodiscard]] core::SimulationError failed(core::SimulationError error) const;
  [[nodiscard]] core::SimulationError environmentFailure(const turtle::EnvironmentError& error) const;
  template <typename Part>
  [[nodiscard]] Outcome guarded(Part&& part);

  turtle::Interpreter interpreter_;
  std::vector<derivation::Derivation> derivations_;         // by plant
  std::vector<derivation::Derivation> displayDerivations_;  // by plant, for drawing: no printf
  std::vector<StepUndo> undo_;                              // by plant
  turtle::QueryBatch queries_;
  std::vector<std::uint64_t> queryOffsets_;  // of each query's parameters in its plant's string (queryCount)
  Pending pending_;
};

/// Runs a part of a step; on a failure of any kind the simulation is as after the last completed step.
template <typename Part>
Simulation::Implementation::Outcome Simulation::Implementation::guarded(Part&& part) {
  try {
    part();
    return std::nullopt;
  } catch (const core::SimulationFailure& failure) {
    undoStep();
    return failed(failure.error());
  } catch (const std::bad_alloc&) {
    undoStep();
    core::SimulationError error;
    error.code = core::SimulationErrorCode::LimitExceeded;
    error.step = completedSteps_ + 1;
    error.message = "step " + std::to_string(error.step) + ": there is not enough memory.";
    return failed(std::move(error));
  }
}

}  // namespace espalier::simulation
