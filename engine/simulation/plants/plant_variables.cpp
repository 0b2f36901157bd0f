#include "engine/simulation/plants/plant_variables.h"

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

namespace {

derivation::PlantState withString(const derivation::PlantState& state, derivation::ModuleString string) {
  PlantVariables variables;
  variables.copyFrom(state);
  derivation::PlantState result;
  variables.copyTo(result);
  result.viewVolume = state.viewVolume;
  result.string = std::move(string);
  return result;
}

}  // namespace

derivation::PlantState sharedState(derivation::PlantState& state) {
  return withString(state, state.string.share());
}

derivation::PlantState sharedState(const derivation::PlantState& state) {
  return withString(state, state.string.share());
}

}  // namespace espalier::simulation
