#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/simulation/plants/plant_variables.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// How one plant goes back to the state after the last completed step.
struct StepUndo {
  PlantVariables variables;  // before the interpretation pass
  bool hasVariables = false;
  std::vector<turtle::ParameterChange> changes;  // parameters overwritten by queries and replies, in order
  derivation::PlantState underived;              // before the derivation, when several plants are derived one by one
  bool hasUnderived = false;
  // for viewers; only noted when changes are followed
  derivation::StepChanges answered;  // from the string before the answers to the one with them
  derivation::StepChanges derived;   // from there to the derived one
  bool isAnswered = false;           // some answer changed something
  bool isDerived = false;

  /// Forgets everything: the step is complete, or was undone.
  void clear();
  /// Takes the derivation back, then the interpretation pass.
  void apply(derivation::PlantState& state);
  /// Takes only the derivation back.
  void applyUnderived(derivation::PlantState& state);
};

}  // namespace espalier::simulation
