#include "engine/language/arithmetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace espalier::language::arithmetic_test {
namespace {

double call(Function function, std::vector<double> arguments) {
  bool dividedByZero = false;
  return callPure(function, arguments, dividedByZero);
}

TEST(Arithmetic, DivisionByZeroDividesByOneAndSetsTheFlag) {
  bool dividedByZero = false;
  EXPECT_EQ(applyBinary(Operation::Divide, 7.0, 2.0, dividedByZero), 3.5);
  EXPECT_FALSE(dividedByZero);
  EXPECT_EQ(applyBinary(Operation::Divide, 7.0, 0.0, dividedByZero), 7.0);
  EXPECT_TRUE(dividedByZero);
}

TEST(Arithmetic, ModuloTruncatesBothOperandsAndTakesTheSignOfTheLeft) {
  bool dividedByZero = false;
  EXPECT_EQ(truncateModulo(7.9, 3.9, dividedByZero), 1.0);
  EXPECT_EQ(truncateModulo(-7.0, 3.0, dividedByZero), -1.0);
  EXPECT_EQ(truncateModulo(7.0, -3.0, dividedByZero), 1.0);
  EXPECT_FALSE(std::signbit(truncateModulo(-6.0, 3.0, dividedByZero)));
  EXPECT_FALSE(dividedByZero);
  EXPECT_EQ(truncateModulo(5.0, 0.5, dividedByZero), 0.0);
  EXPECT_TRUE(dividedByZero);
}

TEST(Arithmetic, ModuloIsTheRemainderOfTheTruncatedNumbersForLargeAndSmallOnes) {
  const std::vector<double> numbers{0.0,  -0.0,   0.9,          1.0,          1.9,          3.0,
                                    7.5,  1000.0, 2147483647.0, 2147483647.5, 2147483648.0, 4294967297.0,
                                    1e15, 1e300,  std::nan(""), HUGE_VAL};
  for (const double a : numbers) {
    for (const double b : numbers) {
      for (const auto& [x, y] : {std::pair(a, b), std::pair(-a, b), std::pair(a, -b), std::pair(-a, -b)}) {
        const double divisor = std::trunc(y);
        const double expected = divisor == 0.0 ? 0.0 : std::fmod(std::trunc(x), divisor) + 0.0;
        bool dividedByZero = false;
        const double value = truncateModulo(x, y, dividedByZero);
        EXPECT_TRUE(value == expected || (std::isnan(value) && std::isnan(expected))) << x << " % " << y;
        EXPECT_EQ(std::signbit(value) && !std::isnan(value), std::signbit(expected) && !std::isnan(expected));
        EXPECT_EQ(dividedByZero, divisor == 0.0) << x << " % " << y;
      }
    }
  }
}

TEST(Arithmetic, OrSkipsWhenTheIntegerIsNoMultipleOf256) {
  EXPECT_TRUE(orSkips(1.0));
  EXPECT_TRUE(orSkips(-2.0));
  EXPECT_TRUE(orSkips(257.9));
  EXPECT_FALSE(orSkips(0.0));
  EXPECT_FALSE(orSkips(0.9));
  EXPECT_FALSE(orSkips(-0.9));
  EXPECT_FALSE(orSkips(512.0));
  EXPECT_FALSE(orSkips(1.0e300));
  EXPECT_FALSE(orSkips(std::nan("")));
}

TEST(Arithmetic, UnaryAndLogicalOperatorsGiveNumbers) {
  bool flag = false;
  EXPECT_EQ(applyUnary(Operation::Negate, 2.0), -2.0);
  EXPECT_EQ(applyUnary(Operation::Not, 0.5), 0.0);
  EXPECT_EQ(applyUnary(Operation::ToBoolean, -3.0), 1.0);
  EXPECT_EQ(applyBinary(Operation::LogicalAnd, 2.0, 3.0, flag), 1.0);
  EXPECT_EQ(applyBinary(Operation::LogicalOr, 0.0, 0.0, flag), 0.0);
  EXPECT_EQ(applyBinary(Operation::Power, 2.0, 10.0, flag), 1024.0);
  EXPECT_EQ(applyBinary(Operation::NotEqual, 2.0, 2.0, flag), 0.0);
  EXPECT_EQ(applyBinary(Operation::GreaterEqual, 2.0, 2.0, flag), 1.0);
}

TEST(Arithmetic, AnglesAreInDegrees) {
  EXPECT_NEAR(call(Function::Sin, {30.0}), 0.5, 1e-15);
  EXPECT_NEAR(call(Function::Cos, {180.0}), -1.0, 1e-15);
  EXPECT_NEAR(call(Function::Tan, {45.0}), 1.0, 1e-15);
  EXPECT_NEAR(call(Function::Asin, {1.0}), 90.0, 1e-12);
  EXPECT_NEAR(call(Function::Acos, {0.5}), 60.0, 1e-12);
  EXPECT_NEAR(call(Function::Atan2, {1.0, -1.0}), 135.0, 1e-12);
}

TEST(Arithmetic, AtanIgnoresTheFirstOfTwoArguments) {
  EXPECT_NEAR(call(Function::Atan, {1.0}), 45.0, 1e-12);
  EXPECT_NEAR(call(Function::Atan, {7.0, 1.0}), 45.0, 1e-12);
}

TEST(Arithmetic, TruncRoundsHalfUp) {
  EXPECT_EQ(call(Function::Trunc, {2.5}), 3.0);
  EXPECT_EQ(call(Function::Trunc, {-2.5}), -2.0);
  EXPECT_EQ(call(Function::Sign, {-0.1}), -1.0);
  EXPECT_EQ(call(Function::Sign, {0.0}), 0.0);
}

TEST(Arithmetic, OwnFunctions) {
  EXPECT_EQ(call(Function::Min, {2.0, -1.0}), -1.0);
  EXPECT_EQ(call(Function::Max, {2.0, -1.0}), 2.0);
  EXPECT_EQ(call(Function::Mod, {-7.0, 3.0}), 2.0);
  EXPECT_EQ(call(Function::Mod, {7.0, -3.0}), -2.0);
  EXPECT_EQ(call(Function::Hypot, {3.0, 4.0}), 5.0);
  EXPECT_EQ(call(Function::Clamp, {9.0, 0.0, 1.0}), 1.0);
  EXPECT_EQ(call(Function::Clamp, {-9.0, 0.0, 1.0}), 0.0);
}

TEST(Arithmetic, TableNamesEveryFunction) {
  EXPECT_STREQ(functionInfo(Function::Sin).name, "sin");
  EXPECT_STREQ(functionInfo(Function::Play).name, "play");
  EXPECT_EQ(allFunctions().size(), static_cast<std::size_t>(Function::Play) + 1);
  EXPECT_TRUE(drawsRandom(Function::Biran));
  EXPECT_FALSE(drawsRandom(Function::Srand));
}

}  // namespace
}  // namespace espalier::language::arithmetic_test
