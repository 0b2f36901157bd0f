#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/worker_team.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/seed_bed.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot_content.h"
#include "engine/simulation/step_undo.h"

namespace espalier::simulation {

/// The state and the parts of a step behind Simulation. simulation.cpp: starting and stepping; answering.cpp: the pass
/// that answers queries; deriving.cpp: the derivation of all plants; births_and_deaths.cpp: seeds and the end of
/// plants; drawing.cpp: looking; persistence.cpp: hash, save, restore.
class Simulation::Implementation {
 public:
  Implementation(Programs programs, std::vector<PlantOrigin> plants,
                 std::unique_ptr<turtle::EnvironmentProcess> environment, SimulationOptions options);

  using Outcome = std::optional<core::SimulationError>;

  [[nodiscard]] Outcome rewind();
  [[nodiscard]] Outcome step();
  [[nodiscard]] Outcome answer();
  [[nodiscard]] bool isFinished() const;
  [[nodiscard]] std::uint64_t derivationLength() const;
  [[nodiscard]] std::uint64_t livingPlantCount() const;
  [[nodiscard]] derivation::DerivationOptions derivationOptions(std::uint32_t plant, const Plant& member) const;
  [[nodiscard]] Outcome draw(turtle::InterpretationOutput output);
  [[nodiscard]] Outcome chainRecords(const turtle::RecordChain* base, turtle::RecordChain& chain);
  [[nodiscard]] std::uint64_t stateHash() const;
  [[nodiscard]] std::uint64_t plantsHash() const;
  [[nodiscard]] const language::Program& programOf(std::size_t plant) const {
    return *models_.programs()[members_[plant].origin.model];
  }
  void save(core::ByteSink& sink);
  [[nodiscard]] Outcome restore(std::string_view snapshot);

  ModelSet models_;
  std::vector<Plant> members_;  // by plant number
  std::unique_ptr<turtle::EnvironmentProcess> environment_;
  SimulationOptions options_;
  turtle::EnvironmentDescription description_;
  std::vector<derivation::PlantState> plants_;  // by plant number; of the dead: empty
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

  /// A seed that took root, until the step is complete.
  struct Seedling {
    Plant member;
    derivation::PlantState state;
    std::unique_ptr<derivation::Derivation> derivation;
  };

  [[nodiscard]] bool isCompatible() const { return models_.compatibility() != core::Compatibility::Espalier; }
  /// Living plants that the step derives: not those that end in it.
  [[nodiscard]] bool isGrowing(std::size_t plant) const;
  [[nodiscard]] std::uint64_t runLength() const;
  [[nodiscard]] std::optional<std::uint64_t> derivationLengthOf(const Plant& member) const;
  [[nodiscard]] std::uint64_t effectiveSeed() const;
  void hashPlants(core::Hasher& hasher) const;
  void makeDerivations();
  void startPlant(std::size_t plant, derivation::PlantState& state) const;
  [[nodiscard]] turtle::EnvironmentContext environmentContext() const;

  // the parts of a step: they throw SimulationFailure and are undone by undoStep
  void answerPass();
  void interpretForQueries();
  void measureGeometry();
  void takeLifeQueries();
  [[nodiscard]] std::uint32_t modelOfSeed(std::size_t query) const;
  void writeLifeReplies();
  void writeReply(std::uint32_t plant, std::uint64_t offset, double value);
  void consultEnvironment();
  void tickEnvironment();
  void exchange();
  void exchangeOnce(std::uint32_t iteration);
  [[nodiscard]] bool hasSettled(const std::vector<double>& sent, const turtle::ReplyBatch& replies) const;
  void rewindPass();
  void requireFiniteReplies() const;
  void writeReplies(const turtle::ReplyBatch& replies);
  void measureViewVolume();
  [[nodiscard]] std::unique_ptr<derivation::Derivation> makeDerivation(std::uint32_t plant, const Plant& member);
  void derivePass();
  void derivePlant(std::size_t plant, bool isKept);
  /// Fails when so many modules and bytes are more than all strings of a simulation may have.
  void requireTogether(std::uint64_t modules, std::uint64_t bytes) const;
  void deriveAll(const std::vector<std::size_t>& plants, bool isKept);
  void deriveTogether(const std::vector<std::size_t>& plants, bool isKept);
  [[nodiscard]] unsigned threadCount() const;
  void deliverMessage(std::uint32_t plant, core::MessageKind kind, std::string_view text);
  void growSeedlings();
  void countStrings();
  void begin();
  void deliverAllFiles();
  void deliverFiles(std::size_t plant, const language::Program& program, derivation::PlantState& state);
  [[nodiscard]] derivation::Derivation& displayDerivation(std::size_t plant);
  void drawPlant(std::size_t plant, const turtle::InterpretationOutput& output);
  void completeStep();
  void endAndBegin();
  void forgetLife();
  [[nodiscard]] std::vector<Plant> founders() const;
  void undoStep();
  [[nodiscard]] core::SimulationError failed(core::SimulationError error) const;
  [[nodiscard]] core::SimulationError environmentFailure(const turtle::EnvironmentError& error) const;
  template <typename Part>
  [[nodiscard]] Outcome guarded(Part&& part);

  // working memory by plant number; null: of a dead plant, and of the second also of one that was not drawn yet
  std::vector<std::unique_ptr<derivation::Derivation>> derivations_;
  std::vector<std::unique_ptr<derivation::Derivation>> displayDerivations_;  // for drawing: no printf
  std::vector<StepUndo> undo_;                                               // by plant
  turtle::QueryBatch queries_;
  std::vector<std::uint64_t> queryOffsets_;  // of each query's parameters in its plant's string (queryCount)
  Pending pending_;
  std::vector<Seed> seeds_;                 // of the step under way
  std::vector<std::uint32_t> dying_;        // plants that end in it, by number
  std::vector<Seedling> seedlings_;         // made in it
  std::unique_ptr<core::WorkerTeam> team_;  // derives plants side by side; null: not needed yet
  // what plants that are derived side by side have to say, by plant; empty: it is passed on at once
  std::vector<std::vector<std::pair<core::MessageKind, std::string>>> heldMessages_;
  std::atomic<std::uint64_t> derivedModules_{0};  // of the plants that were derived in the step under way
  std::atomic<std::uint64_t> derivedBytes_{0};
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
