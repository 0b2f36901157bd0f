#include "engine/derivation/expressions/number_format.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace espalier::number_format_test {
namespace {

std::string format(const std::string& text, std::initializer_list<double> numbers) {
  return derivation::formatNumbers(text, std::vector<double>(numbers));
}

TEST(NumberFormat, PutsOneNumberIntoEachConversion) {
  EXPECT_EQ(format("%g and %5.2f|", {1.5, 2.25}), "1.5 and  2.25|");
}

TEST(NumberFormat, WritesPercentSigns) {
  EXPECT_EQ(format("100%% of %g", {3}), "100% of 3");
}

TEST(NumberFormat, TruncatesNumbersForIntegerConversions) {
  EXPECT_EQ(format("%d %i %ld %03d %x", {2.9, -2.9, 7, 5, 255}), "2 -2 7 005 ff");
  EXPECT_EQ(format("%d", {std::nan("")}), "0");
}

TEST(NumberFormat, WritesCharacters) {
  EXPECT_EQ(format("%c%c", {72, 105}), "Hi");
}

TEST(NumberFormat, TreatsTextConversionsAsNumbers) {
  EXPECT_EQ(format("%s %n %p", {1.5, 2, 3}), "1.5 2 3");
}

TEST(NumberFormat, TakesZeroForMissingNumbers) {
  EXPECT_EQ(format("%g %g", {4}), "4 0");
}

TEST(NumberFormat, CutsHugeWidthsAndStopsAtAnUnfinishedConversion) {
  EXPECT_EQ(format("%999999999d", {1}).size(), 1000U);
  EXPECT_EQ(format("a%", {1}), "a");
  EXPECT_EQ(format("a%12.", {1}), "a");
}

TEST(NumberFormat, WritesTheLargestNumberInFull) {
  EXPECT_EQ(format("%f", {1e308}).size(), 309U + 7U);
}

}  // namespace
}  // namespace espalier::number_format_test
