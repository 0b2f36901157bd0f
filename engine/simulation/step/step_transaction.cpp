#include "engine/simulation/step/step_transaction.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace espalier::simulation {

void StepTransaction::rememberVariables(std::size_t plant, const derivation::PlantState& state) {
  undo_[plant].variables.copyFrom(state);
  undo_[plant].hasVariables = true;
}

void StepTransaction::write(std::size_t plant, derivation::PlantState& state, std::uint64_t module,
                            std::uint64_t offset, double value) {
  undo_[plant].changes.push_back({offset, state.string.parameters()[offset], module});
  state.string.setParameter(offset, value);
}

void StepTransaction::noteAnswers(const std::vector<derivation::PlantState>& states) {
  hasNotedAnswers_ = true;
  std::vector<std::uint64_t> modules;
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    const derivation::ModuleString& string = states[plant].string;
    modules.clear();
    for (const turtle::ParameterChange& change : undo_[plant].changes) {
      if (std::bit_cast<std::uint64_t>(change.before) !=
          std::bit_cast<std::uint64_t>(string.parameters()[change.offset])) {
        modules.push_back(change.module);
      }
    }
    undo_[plant].isAnswered = !modules.empty();
    if (!modules.empty()) {
      std::sort(modules.begin(), modules.end());
      undo_[plant].answered = derivation::StepChanges::ofParameters(modules, string.size());
    }
  }
}

derivation::StepChanges& StepTransaction::derivedChanges(std::size_t plant) {
  undo_[plant].isDerived = true;
  return undo_[plant].derived;
}

void StepTransaction::rememberUnderived(std::size_t plant, const derivation::PlantState& state) {
  undo_[plant].underived = state;
  undo_[plant].hasUnderived = true;
}

derivation::PlantState StepTransaction::before(std::size_t plant, const derivation::PlantState& state) const {
  derivation::PlantState result = state;
  StepUndo undo = undo_[plant];
  undo.apply(result);
  return result;
}

void StepTransaction::takeBack(std::vector<derivation::PlantState>& states) {
  for (std::size_t plant = 0; plant < states.size(); ++plant) {
    undo_[plant].apply(states[plant]);
  }
  isAnswered_ = false;
  hasNotedAnswers_ = false;
}

void StepTransaction::commit() {
  for (StepUndo& undo : undo_) {
    undo.clear();
  }
  isAnswered_ = false;
  hasNotedAnswers_ = false;
  // the batch keeps its memory for the next step
  answer_ = EnvironmentAnswer{.replies = std::move(answer_.replies)};
}

}  // namespace espalier::simulation
