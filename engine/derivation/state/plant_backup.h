#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/state/plant_state.h"

namespace espalier::derivation {

/// The plant before a step, to undo a step that fails. It has everything of a PlantState but the string, which a step
/// swaps only at its end, and the view volume, which a step does not change.
class PlantBackup {
 public:
  void save(const PlantState& state);
  void restore(PlantState& state) const;

 private:
  std::uint64_t step_ = 0;
  std::uint64_t derivationLength_ = 0;
  bool isStopped_ = false;
  std::vector<double> statics_;
  std::vector<InstanceState> instances_;
  RandomState random_;
  FileState files_;
};

}  // namespace espalier::derivation
