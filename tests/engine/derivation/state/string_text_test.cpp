#include "engine/derivation/state/string_text.h"

#include <gtest/gtest.h>

#include "tests/support/derived_model.h"

namespace espalier::string_text_test {
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

TEST(StringText, WhatIsWrittenIsReadBack) {
  DerivedModel model(modelText("", "A(1/3,-2.5e-300)[+(30)F]B", "B --> [A(1,2)]+(4)B\n"));
  model.steps(3);
  const auto read = derivation::parseText(model.program(), model.text());
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(derivation::hashOf(model.program(), *read), derivation::hashOf(model.program(), model.state().string));
  const auto spaced = derivation::parseText(model.program(), " B \n\tA( 1 , 2 )\r\n");
  ASSERT_TRUE(spaced);
  EXPECT_EQ(spaced->size(), 2U);
}

TEST(StringText, MistakesInATextAreNamedWithTheirPlace) {
  DerivedModel model(modelText("", "A(1)B", "B --> B\n"));
  const auto problem = [&model](std::string_view text) {
    const auto read = derivation::parseText(model.program(), text);
    return read ? std::string{} : read.error();
  };
  EXPECT_EQ(problem("B\nBX"),
            "2:2: the model has no module 'X' with 0 parameters: only modules that occur in the model can be read");
  EXPECT_EQ(problem("A(1,2)"), "1:1: the model has no module 'A' with 2 parameters, only with 1");
  EXPECT_EQ(problem("A(1"), "1:4: expected a number, ',' or ')' in the parameters of 'A'");
  EXPECT_EQ(problem("A()"), "1:3: expected a number, ',' or ')' in the parameters of 'A'");
  // 65,537 parameters are not one of a 16-bit count
  std::string many = "A(1";
  for (int i = 0; i < 65'536; ++i) {
    many += ",1";
  }
  EXPECT_EQ(problem(many + ")"), "1:1: the model has no module 'A' with 65537 parameters, only with 1");
  EXPECT_EQ(problem("A(nan)"), "1:3: expected a number, ',' or ')' in the parameters of 'A'");
}

}  // namespace
}  // namespace espalier::string_text_test
