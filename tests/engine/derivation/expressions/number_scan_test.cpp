#include "engine/derivation/expressions/number_scan.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

namespace espalier::derivation::number_scan_test {
namespace {

struct Scan {
  int count = 0;
  std::vector<double> numbers;
  std::string rest;

  bool operator==(const Scan&) const = default;
};

Scan scanned(const std::string& text, const std::string& format, std::size_t targets = 3) {
  std::vector<double> numbers(targets, -9.0);
  std::size_t position = 0;
  const int count = scanNumbers(text, position, format, numbers);
  return {count, numbers, text.substr(position)};
}

TEST(NumberScan, ReadsNumbersOverBlanksAndLines) {
  EXPECT_EQ(scanned("  1.5\n-2e3\t+4 tail", "%lf%f %g"), (Scan{3, {1.5, -2000.0, 4.0}, " tail"}));
  EXPECT_EQ(scanned(".5 7. nan", "%g %g %d"), (Scan{2, {0.5, 7.0, -9.0}, "nan"}));
}

TEST(NumberScan, WholeNumbersStopAtTheFirstOtherCharacter) {
  EXPECT_EQ(scanned("12.5", "%d%g"), (Scan{2, {12.0, 0.5, -9.0}, ""}));
  EXPECT_EQ(scanned("0x1F 017 -8", "%i %i %i"), (Scan{3, {31.0, 15.0, -8.0}, ""}));
  EXPECT_EQ(scanned("ff 17", "%x %o"), (Scan{2, {255.0, 15.0, -9.0}, ""}));
  EXPECT_EQ(scanned("99999999999999999999999", "%d", 1), (Scan{1, {9.2e18}, ""}));
}

TEST(NumberScan, OtherCharactersMustMatch) {
  EXPECT_EQ(scanned("x = 3, y = 4", "x = %g, y = %g", 2), (Scan{2, {3.0, 4.0}, ""}));
  EXPECT_EQ(scanned("x = 3; y = 4", "x = %g, y = %g", 2), (Scan{1, {3.0, -9.0}, "; y = 4"}));
  EXPECT_EQ(scanned("50 % 60", "%g%% %g", 2), (Scan{2, {50.0, 60.0}, ""}));
}

TEST(NumberScan, WidthsStarsAndCharacters) {
  EXPECT_EQ(scanned("123456", "%2d%1d%g"), (Scan{3, {12.0, 3.0, 456.0}, ""}));
  EXPECT_EQ(scanned("1 2 3", "%*g %g %*g %g", 2), (Scan{1, {2.0, -9.0}, ""}));
  EXPECT_EQ(scanned("A 1", "%c%c%g"), (Scan{3, {65.0, 32.0, 1.0}, ""}));
}

TEST(NumberScan, TheEndOfTheTextIsMinusOneOnlyBeforeTheFirstConversion) {
  EXPECT_EQ(scanned(" \n", "%g", 1), (Scan{-1, {-9.0}, ""}));
  EXPECT_EQ(scanned("1", "%g %g", 2), (Scan{1, {1.0, -9.0}, ""}));
  EXPECT_EQ(scanned("word", "%g", 1), (Scan{0, {-9.0}, "word"}));
  EXPECT_EQ(scanned("+-1", "%g", 1), (Scan{0, {-9.0}, "+-1"}));
}

TEST(NumberScan, WhatIsOutOfRangeIsTheNearestDouble) {
  EXPECT_EQ(scanned("1e999 -1e999 1e-999", "%g %g %g"),
            (Scan{3, {std::numeric_limits<double>::max(), -std::numeric_limits<double>::max(), 0.0}, ""}));
}

TEST(NumberScan, MoreConversionsThanTargetsStop) {
  EXPECT_EQ(scanned("1 2 3", "%g %g %g", 2), (Scan{2, {1.0, 2.0}, ""}));
  EXPECT_EQ(scanned("1", "%", 1), (Scan{0, {-9.0}, "1"}));
}

}  // namespace
}  // namespace espalier::derivation::number_scan_test
