#include "environment/soil/solutes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/environment/soil/soils.h"

namespace espalier::environment::solutes_test {
namespace {

/// A column of cells of 1 cm, saturated, through which water flows down by gravity at the saturated conductivity.
RichardsSolver steadyColumn(std::size_t layers) {
  RichardsSolver solver({{1, 1}, layers, {1, 1}, std::vector<double>(layers, 1)}, {kMeanLoam},
                        std::vector<int>(layers, 0));
  for (std::size_t cell = 0; cell < layers; ++cell) {
    solver.setHead(cell, 0);
  }
  return solver;
}

constexpr SoilBorders kSteady{.hasTopHead = true, .topHead = 0, .bottom = SoilBorders::Bottom::Free};

void pass(RichardsSolver& water, SoluteTransport& solutes, double days, const SoilBorders& borders) {
  while (days > 1e-12) {
    const std::vector<double> before = water.state().contents;
    const double passed = water.advance(days, borders, {1e-7});
    ASSERT_GT(passed, 0.0);
    EXPECT_TRUE(solutes.follow(passed, before));
    days -= passed;
  }
}

double total(const SoluteTransport& solutes, std::size_t number) {
  double sum = 0;
  for (const double amount : solutes.amounts(number)) {
    sum += amount;
  }
  return sum;
}

TEST(Solutes, AFrontMovesAsLindstromSays) {
  // steady flow with the velocity v = Ks/θs and the dispersion D = λv, solute with the water that comes in (Lindstrom
  // et al. 1967; van Genuchten & Alves 1982, A2): with t' = t/R, c/c0 = ½ erfc((x − vt')/√(4Dt')) + √(v²t'/πD) e^(−(x −
  // vt')²/4Dt')
  //        − ½ (1 + vx/D + v²t'/D) e^(vx/D) erfc((x + vt')/√(4Dt')). Advection of second order adds nothing to λ = 10
  for (const double sorption : {0.0, 0.43}) {
    auto water = steadyColumn(100);
    SoluteTransport solutes({{.rainConcentration = 3, .dispersivity = 10, .sorption = sorption}}, water);
    const double days = 0.5;
    pass(water, solutes, days, kSteady);
    const double v = 24.96 / 0.43;
    const double d = 10 * v;
    const double t = days / (1 + sorption / 0.43);
    const double width = std::sqrt(4 * d * t);
    for (const std::size_t depth : {0U, 5U, 15U, 30U, 50U}) {
      const double x = static_cast<double>(depth) + 0.5;
      const double expected =
          0.5 * std::erfc((x - v * t) / width) +
          std::sqrt(v * v * t / (3.14159265358979 * d)) * std::exp(-(x - v * t) * (x - v * t) / (4 * d * t)) -
          0.5 * (1 + v * x / d + v * v * t / d) * std::exp(v * x / d) * std::erfc((x + v * t) / width);
      EXPECT_NEAR(solutes.concentration(0, 99 - depth, 0.43) / 3, expected, 0.01) << depth;
    }
    // all that came in is there or has left
    EXPECT_NEAR(total(solutes, 0) + solutes.balances()[0].left, 0, 1e-10);
  }
}

TEST(Solutes, WhatLeavesHasTheConcentrationAtTheBottom) {
  // after many times the water of the column the solution that comes in is everywhere, and as much leaves
  auto water = steadyColumn(10);
  SoluteTransport solutes({{.rainConcentration = 3, .dispersivity = 1}}, water);
  pass(water, solutes, 5, kSteady);
  for (std::size_t cell = 0; cell < 10; ++cell) {
    EXPECT_NEAR(solutes.concentration(0, cell, 0.43), 3.0, 1e-6);
  }
}

TEST(Solutes, AnEvenConcentrationStaysEvenWhileWaterMoves) {
  RichardsSolver water({{2, 2}, 10, {5, 5}, std::vector<double>(10, 5)}, {kMeanLoam}, std::vector<int>(40, 0));
  for (std::size_t cell = 0; cell < 40; ++cell) {
    water.setHead(cell, -20.0 - 13.0 * static_cast<double>(cell % 7));
  }
  SoluteTransport solutes({{.initialConcentration = 2, .rainConcentration = 2, .diffusivity = 1, .dispersivity = 3}},
                          water);
  pass(water, solutes, 3, {.rain = 1.5});
  for (std::size_t cell = 0; cell < 40; ++cell) {
    EXPECT_NEAR(solutes.concentration(0, cell, water.contentOf(cell)), 2.0, 1e-11);
  }
}

TEST(Solutes, DecayAndEvaporationKeepTheBooks) {
  RichardsSolver water({{1, 1}, 10, {5, 5}, std::vector<double>(10, 5)}, {kMeanLoam}, std::vector<int>(10, 0));
  for (std::size_t cell = 0; cell < 10; ++cell) {
    water.setHead(cell, -50);
  }
  SoluteTransport solutes(
      {{.initialConcentration = 1, .diffusivity = 0.5}, {.initialConcentration = 1, .decayRate = 0.1}}, water);
  const double before = total(solutes, 0);
  pass(water, solutes, 4, {.evaporation = 0.4, .driestHead = -15000, .bottom = SoilBorders::Bottom::Closed});
  // water that evaporates leaves its solutes: the surface becomes salty, and nothing is lost
  EXPECT_NEAR(total(solutes, 0) / before, 1, 1e-12);
  EXPECT_GT(solutes.concentration(0, 9, water.contentOf(9)), 1.5);
  EXPECT_NEAR(total(solutes, 1) / before, std::exp(-0.4), 1e-12);
  EXPECT_NEAR(solutes.balances()[1].decayed / 125 / before, 1 - std::exp(-0.4), 1e-9);
}

TEST(Solutes, ABufferedSoilTakesAcidByItsCapacity) {
  // amounts per cm³; c₀ = 10⁻⁶·⁵ mol/L. With β much more than the water holds, a volume that gets A has a pH lower by
  // A/β
  RichardsSolver water({{1, 1}, 1, {1, 1}, {1}}, {kMeanLoam}, {0});
  water.setHead(0, -50);
  const double start = std::pow(10, -6.5) * 1e-3;
  SoluteTransport solutes({{.initialConcentration = start, .bufferCapacity = 2e-5}}, water);
  const auto ph = [&] { return -std::log10(solutes.concentration(0, 0, water.contentOf(0)) * 1e3); };
  EXPECT_NEAR(ph(), 6.5, 1e-4);
  solutes.amounts(0)[0] += 2e-5 * 0.75;
  EXPECT_NEAR(ph(), 5.75, 1e-3);
  solutes.amounts(0)[0] -= 2e-5 * 2;
  EXPECT_NEAR(ph(), 7.75, 1e-3);
  // strong acid: the water holds most of it, and the balance θc − β(pH − 6.5) holds
  solutes.amounts(0)[0] = 1e-3;
  const double concentration = solutes.concentration(0, 0, water.contentOf(0));
  EXPECT_NEAR(water.contentOf(0) * concentration + 2e-5 * std::log10(concentration / start), 1e-3, 1e-12);
}

}  // namespace
}  // namespace espalier::environment::solutes_test
