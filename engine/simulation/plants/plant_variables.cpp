#include "engine/simulation/plants/plant_variables.h"

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

}  // namespace espalier::simulation
