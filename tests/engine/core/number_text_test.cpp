#include "engine/core/number_text.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace espalier::core::number_text_test {
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

// numbers of every size with few and with many digits, and those between two texts
std::vector<double> manyNumbers() {
  std::mt19937_64 engine(11);
  std::vector<double> numbers;
  for (int i = 0; i < 200'000; ++i) {
    const double power = std::pow(10.0, static_cast<double>(engine() % 40) - 20.0);
    const auto digits = static_cast<double>(engine() % (i % 3 == 0 ? 1'000U : 100'000'000U));
    const double number = i % 2 == 0 ? digits * power : digits / power;
    numbers.insert(numbers.end(), {number, -number, std::nextafter(number, 1e300), std::nextafter(number, 0.0)});
    numbers.push_back(std::round(number * 1e6) / 1e6);
    numbers.push_back(number + 0.5 * power);
  }
  for (int exponent = -10; exponent <= 20; ++exponent) {
    const double power = std::pow(10.0, exponent);
    for (const double factor : {1.0, 0.9999995, 0.99999949, 0.99999951, 1.0000005, 9.999995, 1.5, 2.5e-5, 123456.5}) {
      numbers.push_back(power * factor);
    }
  }
  return numbers;
}

TEST(NumberText, ShortestIsThatOfTheLibrary) {
  for (const double number : manyNumbers()) {
    char expected[64];
    const char* const end = std::to_chars(expected, expected + sizeof expected, number == 0.0 ? 0.0 : number).ptr;
    std::string text(static_cast<const char*>(expected), end);
    if (const std::size_t exponent = text.find('e');
        exponent != std::string::npos && text.find('.') == std::string::npos) {
      text.insert(exponent, ".0");
    }
    ASSERT_EQ(shortest(number), text);
  }
}

TEST(NumberText, PercentGOfManyNumbersIsThatOfC) {
  for (const double number : manyNumbers()) {
    char expected[64];
    std::snprintf(expected, sizeof expected, "%g", number);
    ASSERT_EQ(percentG(number), expected);
    ASSERT_EQ(roundThroughPercentG(number), std::strtod(expected, nullptr)) << expected;
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
}  // namespace espalier::core::number_text_test
