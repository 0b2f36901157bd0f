#include "engine/derivation/string_text.h"

#include <gtest/gtest.h>

#include "tests/support/derived_model.h"

namespace espalier {
namespace {

using core::Compatibility;
using test::DerivedModel;
using test::modelText;

TEST(StringText, WritesSymbolsAndParametersWithoutBlanks) {
  EXPECT_EQ(DerivedModel(modelText("", "F [ +(45) A(1, 2.5) ] B", "B --> B\n")).text(), "F[+(45)A(1,2.5)]B");
}

TEST(StringText, UsesShortestNumbersOrSixDigits) {
  const std::string model = modelText("", "A(1/3,1000000*10)", "B --> B\n");
  EXPECT_EQ(DerivedModel(model).text(), "A(0.3333333333333333,1.0e+07)");
  EXPECT_EQ(DerivedModel(model, {}, Compatibility::Cpfg).text(), "A(0.333333,1e+07)");
}

TEST(StringText, EqualStringsHaveEqualHashesAndOthersDiffer) {
  const std::string rest = "A(x) --> B(x)\nB(x) --> A(x+1)\n";
  DerivedModel one(modelText("", "A(1)", rest));
  DerivedModel two(modelText("", "A(1)", rest));
  const auto hash = [](DerivedModel& model) { return derivation::hashOf(model.program(), model.state().string); };
  EXPECT_EQ(hash(one), hash(two));
  one.steps(1);
  EXPECT_NE(hash(one), hash(two));
  two.steps(1);
  EXPECT_EQ(hash(one), hash(two));
  DerivedModel three(modelText("", "A(2)", rest));
  three.steps(1);
  EXPECT_NE(hash(one), hash(three));
}

}  // namespace
}  // namespace espalier
