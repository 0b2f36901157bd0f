#pragma once

#include <cstdint>
#include <vector>

#include "engine/core/random.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// The parts of a PlantState beside its string: what an interpretation can change through homomorphism blocks.
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

/// How one plant goes back to the state after the last completed step.
struct StepUndo {
  PlantVariables variables;  // before the interpretation pass
  bool hasVariables = false;
  std::vector<turtle::ParameterChange> changes;  // parameters overwritten by queries and replies, in order
  derivation::PlantState underived;              // before the derivation, when several plants are derived one by one
  bool hasUnderived = false;

  /// Forgets everything: the step is complete, or was undone.
  void clear();
  /// Takes the derivation back, then the interpretation pass.
  void apply(derivation::PlantState& state);
  /// Takes only the derivation back.
  void applyUnderived(derivation::PlantState& state);
};

}  // namespace espalier::simulation
