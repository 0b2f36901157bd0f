#include "engine/core/elementary.h"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/random.h"

namespace espalier::core {
namespace {

using Unary = double (*)(double);
using Binary = double (*)(double, double);
using ExactUnary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using ExactBinary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

/// A function, MPFR's function of the same name, and where its arguments lie.
struct FunctionCase {
  std::string name;
  Unary unary = nullptr;
  Binary binary = nullptr;
  ExactUnary exactUnary = nullptr;
  ExactBinary exactBinary = nullptr;
  double low = 0.0;  // most arguments are uniform between these
  double high = 0.0;
  std::uint64_t bits = 0;  // FNV-1a of the values of kRecordedArguments arguments
};

constexpr std::uint64_t kShortArguments = 20'000;
constexpr std::uint64_t kLongArguments = 10'000'000;
constexpr std::uint64_t kRecordedArguments = 100'000;

std::vector<FunctionCase> cases() {
  std::vector<FunctionCase> all;
  const auto unary = [&](const char* name, Unary function, ExactUnary exact, double low, double high,
                         std::uint64_t bits) {
    all.push_back({.name = name, .unary = function, .exactUnary = exact, .low = low, .high = high, .bits = bits});
  };
  const auto binary = [&](const char* name, Binary function, ExactBinary exact, double low, double high,
                          std::uint64_t bits) {
    all.push_back({.name = name, .binary = function, .exactBinary = exact, .low = low, .high = high, .bits = bits});
  };
  unary("acos", core::acos, mpfr_acos, -1.0, 1.0, 0xfd26ba60962c6207U);
  unary("asin", core::asin, mpfr_asin, -1.0, 1.0, 0xf59f76edb560b7e8U);
  unary("atan", core::atan, mpfr_atan, -5.0, 5.0, 0x35e1fe9a71a86f3fU);
  unary("cos", core::cos, mpfr_cos, -7.0, 7.0, 0x079512470f93d2b7U);
  unary("exp", core::exp, mpfr_exp, -20.0, 20.0, 0x2a1ee11f7190d25cU);
  unary("exp2", core::exp2, mpfr_exp2, -20.0, 20.0, 0x08e4d4d025975805U);
  unary("expm1", core::expm1, mpfr_expm1, -5.0, 5.0, 0xc2a59c76f4147801U);
  unary("log", core::log, mpfr_log, 0.0, 4.0, 0x36b63c9dc36c5951U);
  unary("log10", core::log10, mpfr_log10, 0.0, 4.0, 0x7371d9e1acde77a6U);
  unary("log1p", core::log1p, mpfr_log1p, -1.0, 4.0, 0x4d4623abb3228654U);
  unary("log2", core::log2, mpfr_log2, 0.0, 4.0, 0xb12e6e6d47e2877bU);
  unary("sin", core::sin, mpfr_sin, -7.0, 7.0, 0x931aa4a0538fdd49U);
  unary("tan", core::tan, mpfr_tan, -7.0, 7.0, 0x9faaa0477e0cafb7U);
  binary("atan2", core::atan2, mpfr_atan2, -5.0, 5.0, 0xd62baf714809e253U);
  binary("hypot", core::hypot, mpfr_hypot, -5.0, 5.0, 0x2c2518173db35027U);
  binary("pow", core::pow, mpfr_pow, 0.0, 4.0, 0x3771220d60ed42e8U);
  return all;
}

/// Argument `draw` of a case: three of four are uniform in its range, the fourth has any exponent and sign.
double argumentOf(const FunctionCase& entry, std::uint64_t index, std::uint32_t draw) {
  static const CounterRandom kRandom(7, 0);
  const auto uniform = [&](std::uint32_t number) {
    return kRandom.uniform(DrawDomain::Environment, 0, index, 4 * draw + number);
  };
  if (index % 4 != 3) {
    return entry.low + (entry.high - entry.low) * uniform(0);
  }
  const double size = std::ldexp(1.0 + uniform(1), static_cast<int>(uniform(2) * 2098.0) - 1074);
  return uniform(3) < 0.5 ? size : -size;
}

double valueOf(const FunctionCase& entry, std::uint64_t index) {
  return entry.unary != nullptr ? entry.unary(argumentOf(entry, index, 0))
                                : entry.binary(argumentOf(entry, index, 0), argumentOf(entry, index, 1));
}

/// MPFR's numbers of one comparison, with 100 bits.
class Exact {
 public:
  Exact() { mpfr_inits2(100, value_, x_, y_, static_cast<mpfr_ptr>(nullptr)); }
  ~Exact() { mpfr_clears(value_, x_, y_, static_cast<mpfr_ptr>(nullptr)); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;

  /// The distance of the computed value from the exact one, in units of the last place of the exact one.
  double error(const FunctionCase& entry, std::uint64_t index) {
    mpfr_set_d(x_, argumentOf(entry, index, 0), MPFR_RNDN);
    if (entry.exactUnary != nullptr) {
      entry.exactUnary(value_, x_, MPFR_RNDN);
    } else {
      mpfr_set_d(y_, argumentOf(entry, index, 1), MPFR_RNDN);
      entry.exactBinary(value_, x_, y_, MPFR_RNDN);
    }
    const double computed = valueOf(entry, index);
    const double rounded = mpfr_get_d(value_, MPFR_RNDN);
    if (std::isnan(rounded) || std::isinf(rounded) || !std::isfinite(computed)) {
      const bool isSame = std::isnan(rounded) ? std::isnan(computed) : rounded == computed;
      return isSame ? 0.0 : std::numeric_limits<double>::infinity();
    }
    mpfr_sub_d(value_, value_, computed, MPFR_RNDN);
    const int exponent = rounded == 0.0 ? -1074 : std::max(std::ilogb(rounded) - 52, -1074);
    mpfr_mul_2si(value_, value_, -exponent, MPFR_RNDN);
    return std::fabs(mpfr_get_d(value_, MPFR_RNDN));
  }

 private:
  mpfr_t value_;
  mpfr_t x_;
  mpfr_t y_;
};

class ElementaryCase : public testing::TestWithParam<FunctionCase> {};
class LongElementaryCase : public testing::TestWithParam<FunctionCase> {};

void expectWithinOneUlp(const FunctionCase& entry, std::uint64_t count) {
  Exact exact;
  double largest = 0.0;
  std::uint64_t worst = 0;
  for (std::uint64_t index = 0; index < count; ++index) {
    const double error = exact.error(entry, index);
    if (error > largest) {
      largest = error;
      worst = index;
    }
  }
  EXPECT_LE(largest, 1.0) << entry.name << "(" << argumentOf(entry, worst, 0) << ", " << argumentOf(entry, worst, 1)
                          << ")";
  testing::Test::RecordProperty("largestError", std::to_string(largest));
}

TEST_P(ElementaryCase, IsWithinOneUlpOfTheExactValue) {
  expectWithinOneUlp(GetParam(), kShortArguments);
}

TEST_P(LongElementaryCase, IsWithinOneUlpOfTheExactValueForTenMillionArguments) {
  expectWithinOneUlp(GetParam(), kLongArguments);
}

TEST_P(ElementaryCase, HasTheRecordedBits) {
  // whoever changes these changes the bits of plants: CHANGELOG.md names the reason
  Hasher hash;
  for (std::uint64_t index = 0; index < kRecordedArguments; ++index) {
    const double value = valueOf(GetParam(), index);
    hash.number(std::isnan(value) ? 0.0 : value);
  }
  EXPECT_EQ(hash.value(), GetParam().bits) << GetParam().name;
}

std::string nameOf(const testing::TestParamInfo<FunctionCase>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Functions, ElementaryCase, testing::ValuesIn(cases()), nameOf);
INSTANTIATE_TEST_SUITE_P(Functions, LongElementaryCase, testing::ValuesIn(cases()), nameOf);

TEST(Elementary, ModesHaveTheirOwnFunctions) {
  const Elementary own(Compatibility::Espalier);
  const Elementary compatible(Compatibility::Cpfg);
  const Elementary batch(Compatibility::CpfgBatch);
  for (std::uint64_t index = 0; index < 10'000; ++index) {
    const double x = argumentOf(cases()[3], 4 * index, 0);
    EXPECT_EQ(own.sin(x), core::sin(x));
    EXPECT_EQ(compatible.sin(x), std::sin(x));
    EXPECT_EQ(batch.pow(x * x, 1.7), std::pow(x * x, 1.7));
    EXPECT_EQ(own.pow(x * x, 1.7), core::pow(x * x, 1.7));
    EXPECT_EQ(own.exp(x), core::exp(x));
    EXPECT_EQ(compatible.exp(x), std::exp(x));
  }
}

TEST(Elementary, ValuesAtTheEndsOfTheRangesAreTheUsual) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(core::pow(0.0, 0.0), 1.0);
  EXPECT_EQ(core::pow(2.0, 10.0), 1024.0);
  EXPECT_EQ(core::pow(-2.0, 3.0), -8.0);
  EXPECT_TRUE(std::isnan(core::pow(-2.0, 0.5)));
  EXPECT_EQ(core::exp(-infinity), 0.0);
  EXPECT_EQ(core::log(0.0), -infinity);
  EXPECT_TRUE(std::isnan(core::log(-1.0)));
  EXPECT_TRUE(std::isnan(core::sin(infinity)));
  EXPECT_TRUE(std::isnan(core::acos(1.5)));
  EXPECT_EQ(core::atan2(0.0, -1.0), std::acos(-1.0));
  EXPECT_TRUE(std::signbit(core::atan2(-0.0, 1.0)));
  EXPECT_EQ(core::hypot(3.0, -4.0), 5.0);
  EXPECT_EQ(core::hypot(1e300, 1e300), 1.4142135623730952e300);
}

}  // namespace
}  // namespace espalier::core
