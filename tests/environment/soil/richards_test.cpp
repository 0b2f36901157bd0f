#include "environment/soil/richards.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/environment/soil/soils.h"

namespace espalier::environment::richards_test {
namespace {

/// The soil of Celia, Bouloutas & Zarba (1990), section 4: cm and, per day, cm/s × 86400.
const SoilLayer kCelia{0.102, 0.368, 0.0335, 2, 0.00922 * 86400, 1e-9};

void setHeads(RichardsSolver& solver, const std::vector<double>& heads) {
  for (std::size_t cell = 0; cell < heads.size(); ++cell) {
    solver.setHead(cell, heads[cell]);
  }
}

RichardsSolver column(std::size_t layers, double size, const SoilLayer& soil, double head) {
  RichardsSolver solver({{1, 1}, layers, {1, 1}, std::vector<double>(layers, size)}, {soil},
                        std::vector<int>(layers, 0));
  setHeads(solver, std::vector<double>(layers, head));
  return solver;
}

void pass(RichardsSolver& solver, double days, const SoilBorders& borders, double tolerance,
          double timeTolerance = 1e-3) {
  while (days > 1e-12) {
    const double passed = solver.advance(days, borders, {tolerance, timeTolerance});
    ASSERT_GT(passed, 0.0);
    days -= passed;
  }
}

TEST(Richards, HydrostaticEquilibriumStays) {
  // h + z the same everywhere: no flow, whatever the soils, above and below the water table
  RichardsSolver solver({{1, 1}, 40, {1, 1}, std::vector<double>(40, 5)}, {kMeanLoam, kCelia}, [] {
    std::vector<int> soilOf(40, 0);
    std::fill(soilOf.begin() + 20, soilOf.end(), 1);
    return soilOf;
  }());
  std::vector<double> heads;
  for (int layer = 0; layer < 40; ++layer) {
    heads.push_back(60.0 - 5.0 * (layer + 0.5));
  }
  setHeads(solver, heads);
  pass(solver, 50, {.bottom = SoilBorders::Bottom::Head, .bottomHead = 60}, 1e-12);
  for (std::size_t cell = 0; cell < 40; ++cell) {
    EXPECT_NEAR(solver.state().heads[cell], heads[cell], 1e-6);
  }
  EXPECT_NEAR(solver.state().balance.drained, 0.0, 1e-9);
}

TEST(Richards, AClosedColumnComesToEquilibriumWithItsWater) {
  // whatever the start, h + z becomes constant, and no water is lost
  auto solver = column(20, 5, kMeanLoam, -40);
  const double water = solver.storedWater();
  pass(solver, 3000, {.bottom = SoilBorders::Bottom::Closed}, 1e-7);
  const auto& heads = solver.state().heads;
  for (std::size_t cell = 1; cell < 20; ++cell) {
    EXPECT_NEAR(heads[cell] + 5.0 * static_cast<double>(cell), heads[0], 0.05);
  }
  EXPECT_NEAR(solver.storedWater() / water, 1.0, 1e-10);
}

/// An independent solution of Celia's case: explicit steps of the θ form's fluxes on a fine grid, water contents
/// inverted to heads by bisection-free formula of n = 2: |αh| = √(Se^−2 − 1).
std::vector<double> explicitInfiltration(int cells, double size, double days) {
  const auto headOf = [](double content) {
    const double effective = (content - 0.102) / 0.266;
    return -std::sqrt(1 / (effective * effective) - 1) / 0.0335;
  };
  const auto conductivity = [](double head) {
    const double s = -0.0335 * head;
    const double film = 1 - s / std::sqrt(1 + s * s);
    return 0.00922 * 86400 * film * film / std::pow(1 + s * s, 0.25);
  };
  const auto contentOf = [](double head) { return 0.102 + 0.266 / std::sqrt(1 + std::pow(0.0335 * head, 2)); };
  std::vector<double> contents(static_cast<std::size_t>(cells), contentOf(-1000));
  std::vector<double> fluxes(static_cast<std::size_t>(cells) + 1);
  const double step = 2e-5;
  for (double day = 0; day < days - step / 2; day += step) {
    // down from the surface, cell 0 is the top
    double headAbove = -75;
    double conductivityAbove = conductivity(-75);
    for (int i = 0; i < cells; ++i) {
      const double head = headOf(contents[static_cast<std::size_t>(i)]);
      const double own = conductivity(head);
      const double distance = i == 0 ? size / 2 : size;
      fluxes[static_cast<std::size_t>(i)] = 0.5 * (own + conductivityAbove) * ((headAbove - head) / distance + 1);
      headAbove = head;
      conductivityAbove = own;
    }
    fluxes.back() = 0.5 * (conductivityAbove + conductivity(-1000)) * ((headAbove + 1000) / (size / 2) + 1);
    for (std::size_t i = 0; i < contents.size(); ++i) {
      contents[i] += step / size * (fluxes[i] - fluxes[i + 1]);
    }
  }
  return contents;
}

TEST(Richards, CeliasInfiltrationAgreesWithAnExplicitSolution) {
  // 100 cm of soil at −1000 cm, −75 cm at the surface and −1000 cm below, 24 hours (Celia et al. 1990, section 4)
  constexpr int kCells = 100;
  const auto expected = explicitInfiltration(kCells, 1.0, 1.0);
  auto solver = column(kCells, 1, kCelia, -1000);
  solver.state().timeStep = 1e-5;
  const double before = solver.storedWater();
  const SoilBorders borders{
      .hasTopHead = true, .topHead = -75, .bottom = SoilBorders::Bottom::Head, .bottomHead = -1000};
  for (int hour = 0; hour < 96; ++hour) {
    pass(solver, 1.0 / 96, borders, 1e-7);
  }
  // the two differ by the order of the time step, and in the mean of K at a face: here of both sides, there over all
  // heads between them
  double front = 0.0;
  for (std::size_t i = 0; i < kCells; ++i) {
    EXPECT_NEAR(solver.contentOf(kCells - 1 - i), expected[i], 0.005) << i << " cm deep";
    front += expected[i] > 0.155 ? 1.0 : 0.0;
  }
  // a steep front, half-way between both contents about 60 cm deep
  EXPECT_GT(front, 50);
  EXPECT_LT(front, 70);
  EXPECT_NEAR(solver.contentOf(kCells - 1), kCelia.content(-75), 0.001);
  // mass balance: the inflow is in the box
  const auto& balance = solver.state().balance;
  EXPECT_NEAR((solver.storedWater() - before) / (balance.infiltrated - balance.drained), 1.0, 1e-10);
}

TEST(Richards, TheBalanceIsExactToTheToleranceWhateverTheWeather) {
  RichardsSolver solver({{3, 2}, 12, {10, 10}, std::vector<double>(12, 5)}, {kMeanLoam, kCelia}, [] {
    std::vector<int> soilOf(72, 0);
    for (std::size_t cell = 0; cell < 72; ++cell) {
      soilOf[cell] = cell % 7 == 3 ? -1 : cell > 36 ? 1 : 0;
    }
    return soilOf;
  }());
  setHeads(solver, std::vector<double>(72, -200));
  const double before = solver.storedWater();
  double taken = 0;
  for (int day = 0; day < 12; ++day) {
    const SoilBorders borders{
        .rain = day % 3 == 0 ? 4.0 : 0.0, .evaporation = day % 3 == 2 ? 0.5 : 0.0, .driestHead = -15000};
    solver.sinks()[1] = 0.01 * solver.cellVolume(1);
    pass(solver, 1, borders, 1e-7);
    taken += 0.01 * solver.cellVolume(1);
  }
  const auto& balance = solver.state().balance;
  EXPECT_GT(balance.drained, 0);
  EXPECT_NEAR((before + balance.infiltrated - balance.drained - taken) / solver.storedWater(), 1.0, 1e-10);
}

TEST(Richards, InfiltrationUnderPondingIsAboutGreenAndAmpts) {
  // F − ψΔθ ln(1 + F/ψΔθ) = Ks t with ψ = ∫ K/Ks dh from the initial head to 0 (Neuman 1976): a sharp front, which sand
  // (Carsel & Parrish 1988) comes near to; solved for the time at which the same water is in
  const SoilLayer sand{0.045, 0.43, 0.145, 2.68, 712.8, 1e-7};
  auto solver = column(100, 1, sand, -100);
  double suction = 0;
  for (double head = -99.95; head < 0; head += 0.1) {
    suction += 0.1 * sand.conductivityAt(head) / sand.conductivity;
  }
  const double deficit = suction * (0.43 - sand.content(-100));
  pass(solver, 0.02, {.hasTopHead = true, .topHead = 0}, 1e-6);
  const double infiltrated = solver.state().balance.infiltrated;
  const double time = (infiltrated - deficit * std::log(1 + infiltrated / deficit)) / sand.conductivity;
  EXPECT_NEAR(time / 0.02, 1.0, 0.12);
}

TEST(Richards, SteepSoilWithLessWaterThanTheToleranceTakesUpRain) {
  // behind the front the soil conducts the rain by gravity alone: K(h) = rain. All of the rain is there, in a front
  // that ends at rain · time/(θ(h) − θr)
  for (const auto& [n, head] : {std::pair(3.0, -100000.0), {5.0, -1000.0}}) {
    const SoilLayer sand{0.05, 0.4, 0.036, n, 200.0, 1e-7};
    auto solver = column(60, 2, sand, head);
    const double before = solver.storedWater();
    ASSERT_LT(sand.content(head) - 0.05, 1e-6) << n;
    pass(solver, 1, {.rain = 10, .bottom = SoilBorders::Bottom::Closed}, 1e-6);
    EXPECT_NEAR(solver.storedWater() - before, 10.0, 1e-9) << n;
    double wet = 0.0;
    double dry = -1e5;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (wet + dry);
      (sand.conductivityAt(middle) > 10.0 ? wet : dry) = middle;
    }
    const double content = sand.content(dry);
    EXPECT_NEAR(solver.contentOf(57), content, 0.002) << n;
    const auto front = static_cast<std::size_t>(60.0 - 10.0 / (content - 0.05) / 2.0);
    EXPECT_LT(solver.contentOf(front - 8), 0.06) << n;
    EXPECT_GT(solver.contentOf(front + 8), content - 0.01) << n;
  }
}

TEST(Richards, RainThatCannotGetInRunsOff) {
  auto solver = column(20, 5, kMeanLoam, -30);
  pass(solver, 0.5, {.rain = 200}, 1e-6);
  const auto& balance = solver.state().balance;
  EXPECT_NEAR(balance.infiltrated + balance.runOff, 100, 1e-9);
  // in the end by gravity through saturated soil: the conductivity
  EXPECT_GT(balance.runOff, 60);
  auto dry = column(20, 5, kMeanLoam, -30);
  pass(dry, 1, {.rain = 1}, 1e-6);
  EXPECT_NEAR(dry.state().balance.infiltrated, 1, 1e-9);
  EXPECT_NEAR(dry.state().balance.runOff, 0, 1e-9);
}

TEST(Richards, EvaporationIsWhatASurfaceAsDryAsItCanBeGives) {
  auto solver = column(100, 1, kMeanLoam, -100);
  pass(solver, 0.5, {.evaporation = 0.3, .driestHead = -15000, .bottom = SoilBorders::Bottom::Closed}, 1e-6);
  EXPECT_NEAR(solver.state().balance.infiltrated, -0.15, 1e-9);
  const double early = solver.state().balance.infiltrated;
  pass(solver, 200, {.evaporation = 0.3, .driestHead = -15000, .bottom = SoilBorders::Bottom::Closed}, 1e-6);
  const double late = solver.state().balance.infiltrated;
  EXPECT_LT(early - late, 20);
  EXPECT_GE(solver.state().heads[99], -15001);
}

TEST(Richards, ASoilDrierThanTheDriestSurfaceTakesNothingFromTheAir) {
  auto solver = column(5, 5, kMeanLoam, -1000);
  const double water = solver.storedWater();
  pass(solver, 5, {.evaporation = 0.4, .driestHead = -100, .bottom = SoilBorders::Bottom::Closed}, 1e-9);
  EXPECT_EQ(solver.state().balance.infiltrated, 0.0);
  EXPECT_NEAR(solver.storedWater() / water, 1.0, 1e-9);
}

TEST(Richards, SeveralColumnsAloneAreEachAsOneColumn) {
  // nothing flows sideways when all columns are alike
  RichardsSolver box({{3, 4}, 10, {7, 9}, std::vector<double>(10, 5)}, {kMeanLoam}, std::vector<int>(120, 0));
  setHeads(box, std::vector<double>(120, -100));
  auto one = column(10, 5, kMeanLoam, -100);
  pass(box, 3, {.rain = 2}, 1e-10);
  pass(one, 3, {.rain = 2}, 1e-10);
  for (std::size_t cell = 0; cell < 120; ++cell) {
    EXPECT_NEAR(box.state().heads[cell], one.state().heads[cell / 12], 1e-6);
  }
}

TEST(Richards, WaterSpreadsAlikeToAllSidesWithoutGravityAcross) {
  // a wet cell in the middle of a layer: the four neighbours get the same
  RichardsSolver box({{5, 5}, 1, {5, 5}, {5}}, {kMeanLoam}, std::vector<int>(25, 0));
  setHeads(box, std::vector<double>(25, -200));
  box.setHead(12, -10);
  pass(box, 1, {.bottom = SoilBorders::Bottom::Closed}, 1e-7);
  const auto& heads = box.state().heads;
  EXPECT_GT(heads[7], -190);
  for (const std::size_t cell : {11U, 13U, 17U}) {
    EXPECT_NEAR(heads[cell], heads[7], 1e-7);
  }
}

}  // namespace
}  // namespace espalier::environment::richards_test
