#include "engine/simulation/step/step_undo.h"

#include <utility>

namespace espalier::simulation {

void StepUndo::clear() {
  hasVariables = false;
  hasUnderived = false;
  changes.clear();
  answered.clear();
  derived.clear();
  isAnswered = false;
  isDerived = false;
}

void StepUndo::applyUnderived(derivation::PlantState& state) {
  if (hasUnderived) {
    std::swap(state, underived);
    hasUnderived = false;
  }
}

void StepUndo::apply(derivation::PlantState& state) {
  applyUnderived(state);
  for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
    state.string.setParameter(change->offset, change->before);
  }
  if (hasVariables) {
    variables.copyTo(state);
  }
  clear();
}

}  // namespace espalier::simulation
