#include "engine/simulation/step_undo.h"

#include <utility>

namespace espalier::simulation {

void PlantVariables::copyFrom(const derivation::PlantState& state) {
  step = state.step;
  derivationLength = state.derivationLength;
  isStopped = state.isStopped;
  statics = state.statics;
  instances = state.instances;
  random = state.random;
  files = state.files;
}

void PlantVariables::copyTo(derivation::PlantState& state) const {
  state.step = step;
  state.derivationLength = derivationLength;
  state.isStopped = isStopped;
  state.statics = statics;
  state.instances = instances;
  state.random = random;
  state.files = files;
}

void StepUndo::clear() {
  hasVariables = false;
  hasUnderived = false;
  changes.clear();
}

void StepUndo::applyUnderived(derivation::PlantState& state) {
  if (hasUnderived) {
    std::swap(state, underived);
    hasUnderived = false;
  }
}

void StepUndo::apply(derivation::PlantState& state) {
  applyUnderived(state);
  const auto parameters = state.string.mutableParameters();
  for (auto change = changes.rbegin(); change != changes.rend(); ++change) {
    parameters[change->offset] = change->before;
  }
  if (hasVariables) {
    variables.copyTo(state);
  }
  clear();
}

}  // namespace espalier::simulation
