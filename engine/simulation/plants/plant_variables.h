#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/state/plant_state.h"

namespace espalier::simulation {

/// The parts of a PlantState beside its string: the blocks of a homomorphism can change all of them.
struct PlantVariables {
  std::uint64_t step = 0;
  std::uint64_t derivationLength = 1;
  bool isStopped = false;
  std::vector<double> statics;
  std::vector<derivation::InstanceState> instances;
  derivation::RandomState random;
  derivation::FileState files;

  void copyFrom(const derivation::PlantState& state);
  void copyTo(derivation::PlantState& state) const;
};

/// The same state with the same string in the same memory (derivation::ModuleString::share).
[[nodiscard]] derivation::PlantState sharedState(derivation::PlantState& state);
/// The same for a state that came from sharedState. Several threads may call it.
[[nodiscard]] derivation::PlantState sharedState(const derivation::PlantState& state);

}  // namespace espalier::simulation
