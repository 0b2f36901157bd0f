#include "engine/derivation/state/module_origins.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/derived_model.h"

namespace espalier::derivation::module_origins_test {
namespace {

using test::DerivedModel;
using test::modelText;

/// The origins of one step, `-` for a new module.
std::string originsOf(DerivedModel& model) {
  ModuleOrigins origins;
  model.derivation().derive(model.state(), nullptr, nullptr, &origins);
  EXPECT_EQ(origins.from().size(), model.state().string.size());
  std::string text;
  for (const std::uint64_t from : origins.from()) {
    text += (text.empty() ? "" : " ") + (from == ModuleOrigins::kNew ? "-" : std::to_string(from));
  }
  return text;
}

TEST(ModuleOrigins, ASuccessorContinuesItsPredecessorOutsideOfBrackets) {
  DerivedModel model(modelText("", "XA", "A --> I(1)[+A]A\nI(l) --> I(l*2)\n"));
  EXPECT_EQ(originsOf(model), "0 - - - - - 1");
  EXPECT_EQ(model.text(), "XI(1)[+A]A");
  // copies, brackets among them, continue themselves
  EXPECT_EQ(originsOf(model), "0 1 2 3 - - - - - 4 5 - - - - - 6");
  EXPECT_EQ(model.text(), "XI(2)[+I(1)[+A]A]I(1)[+A]A");
}

TEST(ModuleOrigins, OfSeveralModulesEachContinuesItsOwn) {
  DerivedModel model(modelText("", "ABAB", "AB --> AAB\n"));
  EXPECT_EQ(originsOf(model), "0 - 1 2 - 3");
  DerivedModel shorter(modelText("", "ABC", "AB --> B\n"));
  EXPECT_EQ(originsOf(shorter), "1 2");
}

TEST(ModuleOrigins, WithDecompositionCutsAndSeveralSystemsToo) {
  DerivedModel decomposed(modelText("", "AB", "A --> C\ndecomposition\nC --> DA\n"));
  EXPECT_EQ(originsOf(decomposed), "- 0 1");
  DerivedModel cut(modelText("", "A[%AC]D", "A --> AB\n"));
  EXPECT_EQ(originsOf(cut), "0 - 1 5 6");
  DerivedModel called(
      "Lsystem: 1\nderivation length: 9\nAxiom: J?(2)JK$J\nJ --> JI\nendlsystem\n"
      "Lsystem: 2\nAxiom: X\nJ --> KJ\nK --> L\nendlsystem\n");
  EXPECT_EQ(originsOf(called), "0 - 1 - 2 - 4 5 -");
  EXPECT_EQ(called.text(), "JI?(2)KJL$JI");
}

TEST(ModuleOrigins, FromRightToLeftToo) {
  DerivedModel model(modelText("", "J(0)J(0)S(5)", "J(b) >> S(a) --> S(a+1)x(a)\nx(a) --> y(a)\n"));
  EXPECT_EQ(originsOf(model), "- - - - 2");
  EXPECT_EQ(model.text(), "S(7)x(6)S(6)x(5)S(5)");
  DerivedModel cut(modelText("", "A[JB%CD[E]]J", "J >> B --> b\nC --> CC\n"));
  EXPECT_EQ(originsOf(cut), "0 1 - 3 10 11");
  EXPECT_EQ(cut.text(), "A[bB]J");
}

}  // namespace
}  // namespace espalier::derivation::module_origins_test
