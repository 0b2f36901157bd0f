#include "clients/espalier/conformance/string_comparison.h"

#include <gtest/gtest.h>

namespace espalier::conformance::string_comparison_test {
namespace {

const Tolerance kTolerance;

std::optional<std::string> firstDifference(std::string_view expected, std::string_view actual,
                                           const Tolerance& tolerance) {
  Deviation largest;
  return conformance::firstDifference(expected, actual, tolerance, largest);
}

TEST(StringComparison, EqualStringsAgree) {
  EXPECT_EQ(firstDifference("A(1,2)[+B]", "A(1,2)[+B]", kTolerance), std::nullopt);
  EXPECT_EQ(firstDifference("", "", kTolerance), std::nullopt);
}

TEST(StringComparison, NumbersAgreeWithinTheTolerance) {
  // 1e-5 of a million is 10
  EXPECT_EQ(firstDifference("A(1000000)", "A(1000009)", kTolerance), std::nullopt);
  EXPECT_EQ(firstDifference("A(0)", "A(6.12323e-17)", kTolerance), std::nullopt);
  EXPECT_EQ(firstDifference("A(0)", "A(-0)", kTolerance), std::nullopt);
  EXPECT_EQ(firstDifference("A(100000)", "A(1.0e+05)", kTolerance), std::nullopt);
}

TEST(StringComparison, TheLargestAcceptedDeviationIsKept) {
  // 1e-5 of 2 and 1e-6 allow 2.1e-5: 1e-5 is a share of 10/21 of it; the other numbers are equal or closer
  Deviation largest;
  EXPECT_EQ(conformance::firstDifference("A(1,2)B(7)C", "A(1,2.00001)B(7.000001)C", {1e-5, 1e-6}, largest),
            std::nullopt);
  EXPECT_NEAR(largest.share, 10.0 / 21.0, 1e-5);
  EXPECT_EQ(largest.place, "module 0: expected A(1,2), actual A(1,2.00001)");
  // a smaller one later changes nothing, and neither does one that is not accepted
  EXPECT_EQ(conformance::firstDifference("D(1)", "D(1.000001)", {1e-5, 1e-6}, largest), std::nullopt);
  EXPECT_NE(conformance::firstDifference("D(1)", "D(2)", {1e-5, 1e-6}, largest), std::nullopt);
  EXPECT_EQ(largest.place, "module 0: expected A(1,2), actual A(1,2.00001)");
}

TEST(StringComparison, WrongSymbolIsSeen) {
  EXPECT_EQ(firstDifference("AB", "AC", kTolerance), "module 1: other symbol: expected B, actual C");
}

TEST(StringComparison, WrongNumberIsSeen) {
  EXPECT_EQ(firstDifference("A(1,2)", "A(1,2.0001)", kTolerance),
            "module 0: parameter 2 differs: expected A(1,2), actual A(1,2.0001)");
  EXPECT_NE(firstDifference("A(0)", "A(0.0001)", kTolerance), std::nullopt);
  EXPECT_NE(firstDifference("A(1)", "A(-1)", kTolerance), std::nullopt);
}

TEST(StringComparison, MissingParameterIsSeen) {
  EXPECT_EQ(firstDifference("A(1,2)", "A(1)", kTolerance),
            "module 0: other number of parameters: expected A(1,2), actual A(1)");
  EXPECT_NE(firstDifference("A(0)", "A", kTolerance), std::nullopt);
}

TEST(StringComparison, MissingAndSurplusModulesAreSeen) {
  EXPECT_EQ(firstDifference("AB", "A", kTolerance), "expected 2 modules, actual 1");
  EXPECT_EQ(firstDifference("A", "AB", kTolerance), "expected 1 modules, actual 2");
}

TEST(StringComparison, ValuesThatAreNotFiniteNeverAgree) {
  EXPECT_NE(firstDifference("A(nan)", "A(nan)", kTolerance), std::nullopt);
  EXPECT_NE(firstDifference("A(1)", "A(inf)", kTolerance), std::nullopt);
}

TEST(StringComparison, MalformedTextIsSeen) {
  EXPECT_EQ(firstDifference("A(1)", "A(1", kTolerance), "actual string: the parameter list of module 0 has no end");
  EXPECT_EQ(firstDifference("A(1)", "A(x)", kTolerance), "actual string: 'x' in module 0 is not a number");
  EXPECT_EQ(firstDifference("A(1)", "A()", kTolerance), "actual string: '' in module 0 is not a number");
}

TEST(StringComparison, DigitsAndPunctuationOutsideParametersAreSymbols) {
  std::string problem;
  const auto modules = splitModules("12.;,A(3)", problem);
  ASSERT_TRUE(modules.has_value()) << problem;
  EXPECT_EQ(modules->size(), 6U);
  EXPECT_EQ(modules->back().parameters, std::vector<double>{3.0});
}

}  // namespace
}  // namespace espalier::conformance::string_comparison_test
