#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/derivation_factory.h"
#include "engine/simulation/plants/plant_drawing.h"
#include "engine/simulation/plants/population.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/step/births_and_deaths.h"
#include "engine/simulation/step/change_log.h"
#include "engine/simulation/step/environment_link.h"
#include "engine/simulation/step/step_transaction.h"
#include "engine/turtle/interpretation/query_stretches.h"

namespace espalier::simulation {

/// The first half of a step: interprets the strings, puts the queries to the environment and writes its replies into
/// the strings.
class AnswerPass {
 public:
  /// The parts of the simulation that the pass works on; all must outlive it.
  struct Parts {
    const ModelSet& models;
    const SimulationOptions& options;
    const DerivationFactory& derivations;
    Population& population;
    StepTransaction& transaction;
    ChangeLog& changes;
    BirthsAndDeaths& births;
    EnvironmentLink& environment;
    PlantDrawing& drawing;
    StepStatistics& statistics;
  };
  explicit AnswerPass(const Parts& parts) : parts_(parts) {}

  /// Throws SimulationFailure; the transaction then takes back what was written.
  void run(std::uint64_t completedSteps);
  /// The run begins again: warnings and notes of the environment may come again.
  void forgetWarnings() {
    said_.clear();
    hasWarnedOfSurplus_ = false;
  }
  /// Bytes of memory that the pass keeps for the next one.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  void interpret();
  /// Whether the next pass would be faster if it knew what has changed since this one.
  [[nodiscard]] bool wantsChanges() const;
  void consultEnvironment();
  void tickEnvironment();
  void exchange();
  void exchangeIterated();
  void exchangeOnce(std::uint32_t iteration);
  void measureGeometry();
  void interpretAgain();
  void requireFiniteReplies() const;
  void writeReplies(const turtle::ReplyBatch& replies);
  [[nodiscard]] bool hasSettled(const std::vector<double>& sent, const turtle::ReplyBatch& replies) const;
  void warnUnsettled() const;
  [[nodiscard]] bool isCompatible() const { return parts_.models.compatibility() != core::Compatibility::Espalier; }
  /// The value as the string holds it: in the compatible modes a 32-bit float.
  [[nodiscard]] double stored(double value) const {
    return isCompatible() ? static_cast<double>(static_cast<float>(value)) : value;
  }
  [[noreturn]] void fail(const turtle::EnvironmentError& error) const;

  Parts parts_;
  std::vector<turtle::QueryStretches> stretches_;  // of the last pass, by plant
  std::uint32_t rest_ = 0;                         // passes to come that do not follow the changes
  std::set<std::string> said_;                     // notes of the environment
  bool hasWarnedOfSurplus_ = false;                // that values were dropped
  // of the step under way
  std::uint64_t completedSteps_ = 0;
  turtle::QueryBatch queries_;
  std::vector<std::uint64_t> queryOffsets_;  // of each query's parameters in its plant's string (queryCount)
};

}  // namespace espalier::simulation
