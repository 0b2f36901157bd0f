#include "engine/simulation/step/step_undo.h"

#include <gtest/gtest.h>

#include <array>

namespace espalier::simulation::step_undo_test {
namespace {

TEST(StepUndo, ParametersGoBackInReverseOrder) {
  derivation::PlantState state;
  state.string.append(3, std::array{5.0, 6.0});
  StepUndo undo;
  undo.changes = {{0, 1.0}, {0, 5.0}, {1, 2.0}};
  undo.apply(state);
  EXPECT_EQ(state.string.parameters()[0], 1.0);
  EXPECT_EQ(state.string.parameters()[1], 2.0);
  EXPECT_TRUE(undo.changes.empty());
}

TEST(StepUndo, TakesTheDerivationBackBeforeThePass) {
  derivation::PlantState state;
  state.string.append(1, std::array{9.0});
  state.step = 2;
  StepUndo undo;
  undo.underived = state;
  undo.hasUnderived = true;
  undo.changes = {{0, 4.0}};
  state.string.clear();
  state.step = 3;
  undo.apply(state);
  EXPECT_EQ(state.step, 2U);
  ASSERT_EQ(state.string.size(), 1U);
  EXPECT_EQ(state.string.parameters()[0], 4.0);
}

TEST(StepUndo, VariablesGoBack) {
  derivation::PlantState state;
  state.statics = {1.0};
  state.instances.push_back({.system = 0, .hasStarted = true, .variables = {7.0}, .elements = {}});
  StepUndo undo;
  undo.variables.copyFrom(state);
  undo.hasVariables = true;
  state.statics[0] = 2.0;
  state.instances[0].variables[0] = 8.0;
  undo.apply(state);
  EXPECT_EQ(state.statics[0], 1.0);
  EXPECT_EQ(state.instances[0].variables[0], 7.0);
}

}  // namespace
}  // namespace espalier::simulation::step_undo_test
