#include "engine/core/number_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace espalier::core {
namespace {

std::string shortest(double value) {
  std::string text;
  appendNumber(text, value, NumberStyle::Shortest);
  return text;
}

std::string percentG(double value) {
  std::string text;
  appendNumber(text, value, NumberStyle::PercentG);
  return text;
}

TEST(NumberText, ShortestReadsBackAsTheSameDouble) {
  std::mt19937_64 engine(7);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = engine();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) {
      EXPECT_EQ(parseNumber(shortest(value)), value) << shortest(value);
    }
  }
}

TEST(NumberText, ExponentGetsAPoint) {
  EXPECT_EQ(shortest(1e5), "1.0e+05");
  EXPECT_EQ(shortest(1e-7), "1.0e-07");
  EXPECT_EQ(shortest(1.5e300), "1.5e+300");
}

TEST(NumberText, WholeNumbersHaveNoPoint) {
  EXPECT_EQ(shortest(3.0), "3");
  EXPECT_EQ(shortest(-12.0), "-12");
  EXPECT_EQ(shortest(0.1), "0.1");
}

TEST(NumberText, NegativeZeroPrintsAsZero) {
  EXPECT_EQ(shortest(-0.0), "0");
}

TEST(NumberText, PercentGIsThatOfC) {
  for (const double value : {0.0, 1.0, 0.1, 123456.0, 1234567.0, 1e-5, 0.00012345678, -2.5e10, 1e100, 6.12323e-17}) {
    char expected[64];
    std::snprintf(expected, sizeof expected, "%g", value);
    EXPECT_EQ(percentG(value), expected);
  }
}

TEST(NumberText, NonFiniteValuesAreNamed) {
  EXPECT_EQ(shortest(std::nan("")), "nan");
  EXPECT_EQ(shortest(-std::numeric_limits<double>::infinity()), "-inf");
}

TEST(NumberText, ParseTakesWhatStrtodTakes) {
  EXPECT_EQ(parseNumber(".5"), 0.5);
  EXPECT_EQ(parseNumber("2."), 2.0);
  EXPECT_EQ(parseNumber("+1e3"), 1000.0);
  EXPECT_EQ(parseNumber("-0.25"), -0.25);
}

TEST(NumberText, ParseRefusesTheRest) {
  for (const char* text : {"", "+", "-", ".", "1e", "0x10", "inf", "nan", "1 ", " 1", "1.2.3", "+-1", "1,5"}) {
    EXPECT_EQ(parseNumber(text), std::nullopt) << text;
  }
}

TEST(NumberText, OutOfRangeIsInfiniteOrZero) {
  EXPECT_EQ(parseNumber("1e999"), HUGE_VAL);
  EXPECT_EQ(parseNumber("-1e999"), -HUGE_VAL);
  EXPECT_EQ(parseNumber("1e-999"), 0.0);
  EXPECT_EQ(parseNumber("0." + std::string(400, '0') + "1"), 0.0);
}

TEST(NumberText, RoundingThroughPercentGKeepsSixDigits) {
  EXPECT_EQ(roundThroughPercentG(0.123456789), 0.123457);
  EXPECT_EQ(roundThroughPercentG(1234567.0), 1234570.0);
  EXPECT_EQ(roundThroughPercentG(5.0), 5.0);
}

}  // namespace
}  // namespace espalier::core
