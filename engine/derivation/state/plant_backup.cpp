#include "engine/derivation/state/plant_backup.h"

namespace espalier::derivation {

void PlantBackup::save(const PlantState& state) {
  step_ = state.step;
  derivationLength_ = state.derivationLength;
  isStopped_ = state.isStopped;
  statics_ = state.statics;
  instances_ = state.instances;
  random_ = state.random;
  files_ = state.files;
}

void PlantBackup::restore(PlantState& state) const {
  state.step = step_;
  state.derivationLength = derivationLength_;
  state.isStopped = isStopped_;
  state.statics = statics_;
  state.instances = instances_;
  state.random = random_;
  state.files = files_;
}

}  // namespace espalier::derivation
