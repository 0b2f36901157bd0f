#include "engine/derivation/expressions/random_source.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace espalier::random_source_test {
namespace {

using core::Compatibility;
using core::DrawDomain;
using derivation::RandomSource;
using derivation::RandomState;

TEST(RandomSource, SequentialMainStreamStartsAsTheReference) {
  RandomSource source(Compatibility::Cpfg, 0);
  RandomState state;
  source.attach(state);
  // X1 = (0x5DEECE66D * 0x330E + 0xB) mod 2^48 = 0x2bbb62dc5101
  EXPECT_EQ(source.uniform(), static_cast<double>(0x2bbb62dc5101ULL) / 281474976710656.0);
}

TEST(RandomSource, SequentialSeedUsesTheLow32BitsOfTheIntegerPart) {
  const auto first = [](double seed) {
    RandomSource source(Compatibility::Cpfg, 0);
    RandomState state;
    source.attach(state);
    source.seed(seed);
    return source.uniform();
  };
  EXPECT_EQ(first(7.9), first(7.0));
  EXPECT_EQ(first(4294967296.0 + 5.0), first(5.0));
  EXPECT_EQ(first(-3.0), first(4294967293.0));
  EXPECT_NE(first(7.0), first(8.0));
}

TEST(RandomSource, FirstNormalNumberBeforeAnySeedIsTheMean) {
  RandomSource source(Compatibility::Cpfg, 0);
  RandomState state;
  source.attach(state);
  EXPECT_EQ(source.normal(5.0, 2.0), 5.0);
  EXPECT_NE(source.normal(5.0, 2.0), 5.0);
}

TEST(RandomSource, SequentialNormalNumbersComeInPairsUntilSeeded) {
  RandomSource source(Compatibility::Cpfg, 0);
  RandomState state;
  source.attach(state);
  source.seed(31);
  const double first = source.normal(0.0, 1.0);
  const core::SequentialRandom after = state.main;
  static_cast<void>(source.normal(0.0, 1.0));
  EXPECT_EQ(state.main.state(), after.state());
  source.seed(31);
  EXPECT_EQ(source.normal(0.0, 1.0), first);
}

TEST(RandomSource, CounterDrawsDependOnTheirKeyAlone) {
  RandomSource source(Compatibility::Espalier, 3);
  RandomState state;
  state.seed = 11;
  state.mainSeed = 11;
  source.attach(state);
  source.key(DrawDomain::Production, 5, 40);
  const double a = source.uniform();
  const double b = source.uniform();
  EXPECT_NE(a, b);
  source.key(DrawDomain::Production, 5, 41);
  EXPECT_NE(source.uniform(), a);
  source.key(DrawDomain::Production, 5, 40);
  EXPECT_EQ(source.uniform(), a);
  EXPECT_EQ(source.uniform(), b);
  EXPECT_EQ(a, core::CounterRandom(11, 3).uniform(DrawDomain::Production, 5, 40, 0));
}

TEST(RandomSource, CounterSelectionIsThatOfTheSeedWhateverSrandDoes) {
  RandomSource source(Compatibility::Espalier, 0);
  RandomState state;
  state.seed = 9;
  source.attach(state);
  const core::CounterRandom expected(9, 0);
  source.seed(1234);
  for (std::uint64_t step = 1; step < 3; ++step) {
    for (std::uint64_t module = 0; module < 10; ++module) {
      EXPECT_EQ(source.selection(step, module), expected.selection(static_cast<std::uint32_t>(step), module));
    }
  }
}

TEST(RandomSource, SrandRepeatsTheDrawsOfAModule) {
  RandomSource source(Compatibility::Espalier, 0);
  RandomState state;
  source.attach(state);
  source.key(DrawDomain::Production, 1, 1);
  source.seed(77);
  const double first = source.uniform();
  source.seed(77);
  EXPECT_EQ(source.uniform(), first);
  EXPECT_EQ(state.mainSeed, 77U);
}

TEST(RandomSource, DistributionsHaveTheirMeanAndVariance) {
  for (const Compatibility compatibility : {Compatibility::Espalier, Compatibility::Cpfg}) {
    RandomSource source(compatibility, 0);
    RandomState state;
    state.mainSeed = 5;
    source.attach(state);
    source.seed(12);
    constexpr int kCount = 20000;
    double normalSum = 0.0;
    double normalSquares = 0.0;
    double betaSum = 0.0;
    double binomialSum = 0.0;
    for (int i = 0; i < kCount; ++i) {
      source.key(DrawDomain::Production, 1, static_cast<std::uint64_t>(i));
      const double normal = source.normal(3.0, 2.0);
      normalSum += normal;
      normalSquares += (normal - 3.0) * (normal - 3.0);
      betaSum += source.beta(2.0, 3.0);
      binomialSum += source.binomial(10.0, 0.3);
    }
    // means 3, 2/5 and 3; tolerances are five standard errors: 5 * sigma / sqrt(20000)
    EXPECT_NEAR(normalSum / kCount, 3.0, 5.0 * 2.0 / std::sqrt(kCount));
    EXPECT_NEAR(normalSquares / kCount, 4.0, 5.0 * 4.0 * std::sqrt(2.0 / kCount));
    EXPECT_NEAR(betaSum / kCount, 0.4, 5.0 * 0.2 / std::sqrt(kCount));
    EXPECT_NEAR(binomialSum / kCount, 3.0, 5.0 * std::sqrt(2.1 / kCount));
  }
}

TEST(RandomSource, BetaEndsForArgumentsItCannotWorkFor) {
  RandomSource source(Compatibility::Cpfg, 0);
  RandomState state;
  source.attach(state);
  static_cast<void>(source.beta(std::nan(""), 1.0));
  static_cast<void>(source.beta(-1.0, -1.0));
  static_cast<void>(source.beta(1e-300, 1e-300));
  SUCCEED();
}

TEST(RandomSource, PrivateStreamLeavesTheMainStreamAlone) {
  for (const Compatibility compatibility : {Compatibility::Espalier, Compatibility::Cpfg}) {
    RandomSource source(compatibility, 0);
    RandomState state;
    source.attach(state);
    source.seed(8);
    const RandomState before = state;
    source.key(DrawDomain::Interpretation, 0, 0);
    source.startPrivateStream(4);
    source.usePrivateStream(true);
    const double first = source.uniform();
    source.seed(99);
    source.usePrivateStream(false);
    EXPECT_EQ(state.main.state(), before.main.state());
    EXPECT_EQ(state.mainSeed, before.mainSeed);
    // started again it repeats
    source.key(DrawDomain::Interpretation, 0, 0);
    source.startPrivateStream(4);
    source.usePrivateStream(true);
    EXPECT_EQ(source.uniform(), first);
    source.usePrivateStream(false);
  }
}

}  // namespace
}  // namespace espalier::random_source_test
