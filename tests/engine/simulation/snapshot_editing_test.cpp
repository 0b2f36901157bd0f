#include "engine/simulation/snapshot_editing.h"

#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::snapshot_editing_test {
namespace {

constexpr const char* kEditedTree =
    "Lsystem: 1\nderivation length: 9\nStart: {size = 1; rate = 2;}\n"
    "Axiom: F(1)[+(30)F(2)A]F(3)A\nA : {size = size + rate;} * --> F(size)A\nendlsystem\n";

/// The string after the edit, or the message of its error.
std::string edited(const StringEdit& edit) {
  const auto program = compileText(kEditedTree);
  Simulation simulation(program, {{}}, nullptr, {});
  expectSuccess(simulation.rewind());
  const EditedSnapshot outcome = editString(snapshotOf(simulation), edit);
  if (!outcome) {
    return outcome.error().message;
  }
  expectSuccess(simulation.restore(*outcome));
  return simulation.stringText();
}

using Kind = StringEdit::Kind;

TEST(SnapshotEditing, PruneTakesWhatTheModuleCarries) {
  // F(1) [ +(30) F(2) A ] F(3) A
  EXPECT_EQ(edited({Kind::Prune, 0, 3, {}}), "F(1)[+(30)]F(3)A");
  EXPECT_EQ(edited({Kind::Prune, 0, 1, {}}), "F(1)F(3)A");
  EXPECT_EQ(edited({Kind::Prune, 0, 6, {}}), "F(1)[+(30)F(2)A]");
  EXPECT_EQ(edited({Kind::Prune, 0, 0, {}}), "");
  EXPECT_EQ(edited({Kind::Prune, 0, 5, {}}), "Module 5 is the end of a branch. Prune one before it.");
}

TEST(SnapshotEditing, InsertAndReplacePutModulesInTheirPlace) {
  EXPECT_EQ(edited({Kind::Insert, 0, 6, {{"+", {15.0}}}}), "F(1)[+(30)F(2)A]+(15)F(3)A");
  EXPECT_EQ(edited({Kind::Insert, 0, 8, {{"[", {}}, {"A", {}}, {"]", {}}}}), "F(1)[+(30)F(2)A]F(3)A[A]");
  EXPECT_EQ(edited({Kind::Replace, 0, 2, {{"+", {60.0}}, {"F", {0.5}}}}), "F(1)[+(60)F(0.5)F(2)A]F(3)A");
}

TEST(SnapshotEditing, WhatDoesNotFitIsRefused) {
  EXPECT_EQ(edited({Kind::Insert, 0, 9, {}}), "There is no module 9; the string has 8, numbered from 0.");
  EXPECT_EQ(edited({Kind::Prune, 0, 8, {}}), "There is no module 8; the string has 8, numbered from 0.");
  EXPECT_EQ(edited({Kind::Insert, 1, 0, {}}), "There is no plant 1; there are 1, numbered from 0.");
  EXPECT_EQ(edited({Kind::Insert, 0, 0, {{"B", {1.0}}}}).substr(0, 52),
            "The model has no module 'B' with 1 parameters. It ha");
  EXPECT_EQ(edited({Kind::Insert, 0, 0, {{"]", {}}}}),
            "The modules close a branch that they do not open. Give as many '[' as ']', each '[' first.");
  EXPECT_EQ(edited({Kind::Insert, 0, 0, {{"[", {}}}}),
            "The modules open a branch that they do not close. Give as many ']' as '['.");
  EXPECT_EQ(edited({Kind::Replace, 0, 1, {}}), "Module 1 is a bracket and cannot be replaced. Prune it.");
  EXPECT_EQ(edited({Kind::Insert, 0, 0, {{"F", {std::numeric_limits<double>::infinity()}}}}),
            "A parameter of 'F' is NaN or infinite. Give finite numbers.");
}

TEST(SnapshotEditing, CallsOfSubLSystemsAreNotPutIn) {
  // the string has no call yet, the model has
  const auto program = compileText(
      "Lsystem: 1\nderivation length: 4\nAxiom: B\nB --> ?(5)L$B\nendlsystem\nLsystem: 5\nAxiom: X\nL --> "
      "l+L\nendlsystem\n");
  Simulation simulation(program, {{}}, nullptr, {});
  expectSuccess(simulation.rewind());
  const auto refused = editString(snapshotOf(simulation), {Kind::Insert, 0, 0, {{"?", {5.0}}, {"L", {}}, {"$", {}}}});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().message, "A call of a sub-L-system cannot be put in: its variables would be missing.");
}

TEST(SnapshotEditing, VariablesHaveTheirNewValuesInTheNextStep) {
  const auto program = compileText(kEditedTree);
  Simulation simulation(program, {{}}, nullptr, {});
  expectSuccess(simulation.rewind());
  const EditedSnapshot changed = setVariables(snapshotOf(simulation), {program}, {{"rate", 10.0}});
  ASSERT_TRUE(changed.has_value());
  expectSuccess(simulation.restore(*changed));
  expectSuccess(simulation.step());
  EXPECT_EQ(simulation.stringText(), "F(1)[+(30)F(2)F(11)A]F(3)F(21)A");
  const auto unknown = setVariables(snapshotOf(simulation), {program}, {{"rat", 10.0}});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().message.substr(0, 59), "The model has no variable 'rat'. Did you mean 'rate'? Avail");
}

}  // namespace
}  // namespace espalier::simulation::snapshot_editing_test
