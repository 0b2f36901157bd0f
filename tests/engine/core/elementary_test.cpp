#include "engine/core/elementary.h"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "tests/bits/elementary_cases.h"

namespace espalier::core::elementary_test {
namespace {

using test::elementaryArgument;
using test::ElementaryCase;

constexpr std::uint64_t kShortArguments = 20'000;
constexpr std::uint64_t kLongArguments = 10'000'000;

using ExactUnary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
using ExactBinary = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_srcptr, mpfr_rnd_t);

const std::map<std::string, ExactUnary> kExactUnary{
    {"acos", mpfr_acos}, {"asin", mpfr_asin},   {"atan", mpfr_atan}, {"cos", mpfr_cos},     {"exp", mpfr_exp},
    {"exp2", mpfr_exp2}, {"expm1", mpfr_expm1}, {"log", mpfr_log},   {"log10", mpfr_log10}, {"log1p", mpfr_log1p},
    {"log2", mpfr_log2}, {"sin", mpfr_sin},     {"tan", mpfr_tan}};
const std::map<std::string, ExactBinary> kExactBinary{{"atan2", mpfr_atan2}, {"hypot", mpfr_hypot}, {"pow", mpfr_pow}};

/// MPFR's numbers of one comparison, with 100 bits.
class Exact {
 public:
  explicit Exact(const ElementaryCase& entry)
      : entry_(entry),
        unary_(entry.unary != nullptr ? kExactUnary.at(entry.name) : nullptr),
        binary_(entry.binary != nullptr ? kExactBinary.at(entry.name) : nullptr) {
    mpfr_inits2(100, value_, x_, y_, static_cast<mpfr_ptr>(nullptr));
  }
  ~Exact() { mpfr_clears(value_, x_, y_, static_cast<mpfr_ptr>(nullptr)); }
  Exact(const Exact&) = delete;
  Exact& operator=(const Exact&) = delete;

  /// The distance of a computed value from the exact one, in units of the last place of the exact one.
  double error(std::uint64_t index) {
    mpfr_set_d(x_, elementaryArgument(entry_, index, 0), MPFR_RNDN);
    if (unary_ != nullptr) {
      unary_(value_, x_, MPFR_RNDN);
    } else {
      mpfr_set_d(y_, elementaryArgument(entry_, index, 1), MPFR_RNDN);
      binary_(value_, x_, y_, MPFR_RNDN);
    }
    const double computed = test::elementaryValue(entry_, index);
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
  const ElementaryCase& entry_;
  ExactUnary unary_;
  ExactBinary binary_;
  mpfr_t value_;
  mpfr_t x_;
  mpfr_t y_;
};

class ElementaryFunctions : public testing::TestWithParam<ElementaryCase> {};
class LongElementaryFunctions : public testing::TestWithParam<ElementaryCase> {};

void expectWithinOneUlp(const ElementaryCase& entry, std::uint64_t count) {
  Exact exact(entry);
  double largest = 0.0;
  std::uint64_t worst = 0;
  for (std::uint64_t index = 0; index < count; ++index) {
    const double error = exact.error(index);
    if (error > largest) {
      largest = error;
      worst = index;
    }
  }
  EXPECT_LE(largest, 1.0) << entry.name << "(" << elementaryArgument(entry, worst, 0) << ", "
                          << elementaryArgument(entry, worst, 1) << ")";
  testing::Test::RecordProperty("largestError", std::to_string(largest));
}

TEST_P(ElementaryFunctions, IsWithinOneUlpOfTheExactValue) {
  expectWithinOneUlp(GetParam(), kShortArguments);
}

TEST_P(LongElementaryFunctions, IsWithinOneUlpOfTheExactValueForTenMillionArguments) {
  expectWithinOneUlp(GetParam(), kLongArguments);
}

TEST_P(ElementaryFunctions, HasTheRecordedBits) {
  EXPECT_EQ(test::elementaryBits(GetParam()), GetParam().bits) << GetParam().name;
}

std::string nameOf(const testing::TestParamInfo<ElementaryCase>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Each, ElementaryFunctions, testing::ValuesIn(test::elementaryCases()), nameOf);
INSTANTIATE_TEST_SUITE_P(Each, LongElementaryFunctions, testing::ValuesIn(test::elementaryCases()), nameOf);

TEST(Elementary, ModesHaveTheirOwnFunctions) {
  const Elementary own(Compatibility::Espalier);
  const Elementary compatible(Compatibility::Cpfg);
  const Elementary batch(Compatibility::CpfgBatch);
  for (std::uint64_t index = 0; index < 10'000; ++index) {
    const double x = 0.0007 * static_cast<double>(index);
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
}  // namespace espalier::core::elementary_test
