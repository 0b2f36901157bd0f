#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/derivation/state/plant_state.h"
#include "engine/simulation/step/step_undo.h"
#include "engine/turtle/environment_process.h"

namespace espalier::simulation {

/// The environment's finished work for the step under way. A step that is tried again does not ask for it twice.
struct EnvironmentAnswer {
  bool hasReplies = false;
  bool hasTicked = false;
  turtle::ReplyBatch replies;
};

/// One step as a transaction over the plants: it remembers everything that the step overwrites, and takes it back when
/// the step fails. The environment's answer survives a failed step and ends with a completed one.
class StepTransaction {
 public:
  explicit StepTransaction(std::size_t plantCount = 0, EnvironmentAnswer answer = {})
      : undo_(plantCount), answer_(std::move(answer)) {}

  /// Plants were born.
  void setPlantCount(std::size_t plantCount) { undo_.resize(plantCount); }
  /// The plant has ended: there is nothing to take back.
  void forget(std::size_t plant) { undo_[plant] = StepUndo(); }

  /// Before the interpretation of a plant: its homomorphism can change variables.
  void rememberVariables(std::size_t plant, const derivation::PlantState& state);
  /// The parameters that an interpretation of the plant overwrites are added here.
  [[nodiscard]] std::vector<turtle::ParameterChange>& changesOf(std::size_t plant) { return undo_[plant].changes; }
  /// Sets one parameter of the plant's string, which is one of `module`.
  void write(std::size_t plant, derivation::PlantState& state, std::uint64_t module, std::uint64_t offset,
             double value);
  /// The answers are complete: notes which modules of each plant they changed.
  void noteAnswers(const std::vector<derivation::PlantState>& states);
  /// The derivation of a plant says here what it left of the string.
  [[nodiscard]] derivation::StepChanges& derivedChanges(std::size_t plant);
  [[nodiscard]] bool hasNotedAnswers() const { return hasNotedAnswers_; }
  /// The part of a plant's string that the answers left unchanged; null: they changed nothing, or nobody wants to know.
  [[nodiscard]] const derivation::StepChanges* answered(std::size_t plant) const {
    return undo_[plant].isAnswered ? &undo_[plant].answered : nullptr;
  }
  /// The part of it that the derivation left unchanged; null: the plant was not derived, or nobody wants to know.
  [[nodiscard]] const derivation::StepChanges* derived(std::size_t plant) const {
    return undo_[plant].isDerived ? &undo_[plant].derived : nullptr;
  }
  /// Before the derivation of a plant.
  void rememberUnderived(std::size_t plant, const derivation::PlantState& state);

  /// The strings hold the environment's replies.
  [[nodiscard]] bool isAnswered() const { return isAnswered_; }
  void setAnswered() { isAnswered_ = true; }
  [[nodiscard]] EnvironmentAnswer& answer() { return answer_; }
  [[nodiscard]] const EnvironmentAnswer& answer() const { return answer_; }

  /// The plant as it was after the last completed step.
  [[nodiscard]] derivation::PlantState before(std::size_t plant, const derivation::PlantState& state) const;
  /// Takes the step back. The environment's answer stays.
  void takeBack(std::vector<derivation::PlantState>& states);
  /// The step is complete: nothing of it can be taken back.
  void commit();

 private:
  std::vector<StepUndo> undo_;  // by plant number
  bool isAnswered_ = false;
  bool hasNotedAnswers_ = false;
  EnvironmentAnswer answer_;
};

}  // namespace espalier::simulation
