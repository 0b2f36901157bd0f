// Soil water and solutes against solutions of their equations that share no code with the solver.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "environment/soil/richards.h"
#include "environment/soil/solutes.h"
#include "tests/environment/soil/soils.h"

namespace espalier::environment::soil_benchmarks_test {
namespace {

RichardsSolver columnOf(const SoilLayer& soil, std::vector<double> heights, double head) {
  const std::size_t layers = heights.size();
  RichardsSolver solver({{1, 1}, layers, {1, 1}, std::move(heights)}, {soil}, std::vector<int>(layers, 0));
  for (std::size_t cell = 0; cell < layers; ++cell) {
    solver.setHead(cell, head);
  }
  return solver;
}

void letPass(RichardsSolver& solver, double days, const SoilBorders& borders, double timeTolerance) {
  while (days > 1e-12) {
    const double passed = solver.advance(days, borders, {1e-6, timeTolerance});
    ASSERT_GT(passed, 0.0);
    days -= passed;
  }
}

/// Depth of the point where the content falls below a value, from the surface of cells of one height.
double depthOfContent(const RichardsSolver& solver, double height, double content) {
  const std::size_t layers = solver.cellCount();
  for (std::size_t i = 1; i < layers; ++i) {
    const double above = solver.contentOf(layers - i);
    const double below = solver.contentOf(layers - 1 - i);
    if (above >= content && below < content) {
      return (static_cast<double>(i) - 0.5 + (above - content) / (above - below)) * height;
    }
  }
  return NAN;
}

struct Front {
  SoilLayer soil;
  double surfaceHead;  // behind the front
  double from, until;  // days
};

TEST(SoilBenchmarks, AFrontMovesWithTheSpeedOfItsWave) {
  // a wave that keeps its form moves with (K₀ − Ki)/(θ₀ − θi) (Vanderborght et al. 2005, infiltration): 0.5 %
  for (const Front& front : {Front{kLoam, 0.0, 0.2, 0.5}, Front{kClay, 0.0, 0.05, 0.1}}) {
    const double speed = (front.soil.conductivityAt(front.surfaceHead) - front.soil.conductivityAt(-400.0)) /
                         (front.soil.content(front.surfaceHead) - front.soil.content(-400.0));
    auto solver = columnOf(front.soil, std::vector<double>(300, 0.5), -400.0);
    const double before = solver.storedWater();
    const double middle = 0.5 * (front.soil.content(front.surfaceHead) + front.soil.content(-400.0));
    letPass(solver, front.from, {.rain = 100.0}, 1e-3);
    const double first = depthOfContent(solver, 0.5, middle);
    letPass(solver, front.until - front.from, {.rain = 100.0}, 1e-3);
    const double second = depthOfContent(solver, 0.5, middle);
    EXPECT_NEAR((second - first) / (front.until - front.from) / speed, 1.0, 0.005);
    const auto& balance = solver.state().balance;
    EXPECT_NEAR((before + balance.infiltrated - balance.drained) / solver.storedWater(), 1.0, 1e-10);
  }
}

TEST(SoilBenchmarks, SteadyFlowAboveAWaterTableHasTheProfileOfItsEquation) {
  // dh/dz = q/K(h) − 1 with h = 0 at the lower border, integrated here by Runge and Kutta's method: 0.5 % + 0.1 cm
  for (const double flow : {0.5, 0.05, -0.05}) {
    auto solver = columnOf(kLoam, std::vector<double>(100, 1.0), -30.0);
    const SoilBorders borders{.rain = std::max(flow, 0.0),
                              .evaporation = std::max(-flow, 0.0),
                              .driestHead = -15000.0,
                              .bottom = SoilBorders::Bottom::Head};
    letPass(solver, 2000.0, borders, 1e-3);
    const auto slope = [&](double head) { return flow / kLoam.conductivityAt(head) - 1.0; };
    double head = 0.0;
    constexpr double kStep = 0.005;
    for (int i = 0; i < 20'000; ++i) {
      const double k1 = slope(head);
      const double k2 = slope(head + 0.5 * kStep * k1);
      const double k3 = slope(head + 0.5 * kStep * k2);
      const double k4 = slope(head + kStep * k3);
      head += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      if (i % 200 == 99) {
        EXPECT_NEAR(solver.state().heads[static_cast<std::size_t>(i / 200)], head, 0.1 + 0.005 * std::abs(head))
            << i / 200 << " cm above the table, flow " << flow;
      }
    }
  }
}

/// Infiltration into Gardner's soil above a water table (Srivastava & Yeh 1991): K/Ks at a height, in units of 1/α, of
/// a column of length `length`, when the flow from above changes from `before` to `after` at time 0.
double relativeConductivity(double height, double time, double length, double before, double after) {
  const double steady = after - (after - 1.0) * std::exp(-height);
  double sum = 0.0;
  for (int n = 1; n < 400; ++n) {
    // λ: tan(λL) = −2λ, one root in each ((n − 1/2)π, nπ)/L
    double low = (static_cast<double>(n) - 0.5) * std::numbers::pi / length + 1e-13;
    double high = static_cast<double>(n) * std::numbers::pi / length;
    for (int round = 0; round < 100; ++round) {
      const double middle = 0.5 * (low + high);
      const bool isPositive = std::sin(middle * length) + 2.0 * middle * std::cos(middle * length) > 0.0;
      const bool isPositiveBelow = std::sin(low * length) + 2.0 * low * std::cos(low * length) > 0.0;
      (isPositive == isPositiveBelow ? low : high) = middle;
    }
    const double root = 0.5 * (low + high);
    sum += std::sin(root * height) * std::sin(root * length) * std::exp(-root * root * time) /
           (1.0 + length / 2.0 + 2.0 * root * root * length);
  }
  return steady - 4.0 * (after - before) * std::exp((length - height) / 2.0) * std::exp(-time / 4.0) * sum;
}

TEST(SoilBenchmarks, InfiltrationIntoGardnersSoilIsThatOfTheSeries) {
  // 100 cm above a water table, α 0.1/cm, Ks 1 cm/h, flow 0.1 and then 0.9 cm/h, θs − θr 0.34: 0.1 cm with 0.5 cm cells
  const SoilLayer soil{0.06, 0.4, 0.1, 2.0, 24.0, 1e-9, SoilLayer::Function::Gardner};
  auto solver = columnOf(soil, std::vector<double>(200, 0.5), -10.0);
  const SoilBorders before{.rain = 0.1 * 24.0, .bottom = SoilBorders::Bottom::Head};
  letPass(solver, 100.0, before, 1e-3);
  const SoilBorders after{.rain = 0.9 * 24.0, .bottom = SoilBorders::Bottom::Head};
  double hours = 0.0;
  for (const double until : {1.0, 5.0, 10.0, 20.0}) {
    letPass(solver, (until - hours) / 24.0, after, 1e-5);
    hours = until;
    for (const std::size_t cell : {20U, 60U, 100U, 140U, 180U, 199U}) {
      const double height = (static_cast<double>(cell) + 0.5) * 0.5;
      const double expected = std::log(relativeConductivity(0.1 * height, 0.1 * hours / 0.34, 10.0, 0.1, 0.9)) / 0.1;
      EXPECT_NEAR(solver.state().heads[cell], expected, 0.1) << height << " cm, " << hours << " h";
    }
  }
}

TEST(SoilBenchmarks, EvaporationFallsAsOneOverTheRootOfTime) {
  // after a dry surface has formed, E = S/(2√t') (Lockington 1994) without gravity: loam, −200 cm, S = 0.1390981
  // cm/day^½; gravity holds back some per cent. Cells grow from 0.01 cm
  std::vector<double> heights;
  double height = 0.01;
  for (double sum = 0.0; sum < 100.0; sum += height, height = std::min(height * 1.1, 2.0)) {
    heights.insert(heights.begin(), height);
  }
  auto solver = columnOf(kLoam, heights, -200.0);
  const SoilBorders borders{.evaporation = 0.1, .driestHead = -10'000.0, .bottom = SoilBorders::Bottom::Closed};
  const double sorptivity = 0.1390981;
  const double potential = sorptivity * sorptivity / (2.0 * 0.1 * 0.1);
  double day = 0.0;
  for (const double until : {2.0, 4.0, 10.0}) {
    letPass(solver, until - day, borders, 1e-4);
    day = until;
    const double expected = sorptivity / (2.0 * std::sqrt(potential / 2.0 + day - potential));
    EXPECT_NEAR(-solver.surfaceFlux(solver.cellCount() - 1) / expected, 0.96, 0.05) << day;
  }
}

TEST(SoilBenchmarks, ASoluteFrontIsThatOfOgataAndBanksAndOfSecondOrder) {
  // the surface keeps c₀: c/c₀ = ½ erfc((x − vt)/√(4Dt)) + ½ e^(vx/D) erfc((x + vt)/√(4Dt))
  const auto errorOf = [](double size) {
    const auto layers = static_cast<std::size_t>(std::lround(60.0 / size));
    auto water = columnOf(kLoam, std::vector<double>(layers, size), 0.0);
    SoluteTransport solutes({{.rainConcentration = 1.0, .dispersivity = 2.0}}, water, true);
    const SoilBorders borders{.hasTopHead = true, .topHead = 0.0, .bottom = SoilBorders::Bottom::Free};
    const double days = 0.15;
    for (double left = days; left > 1e-12;) {
      const std::vector<double> before = water.state().contents;
      const double passed = water.advance(left, borders, {1e-6, 1e-3});
      EXPECT_TRUE(solutes.follow(passed, before));
      left -= passed;
    }
    const double v = kLoam.conductivity / kLoam.saturatedContent;
    const double d = 2.0 * v;
    double worst = 0.0;
    for (double x = size / 2.0; x < 50.0; x += size) {
      const double width = std::sqrt(4.0 * d * days);
      const double expected =
          0.5 * std::erfc((x - v * days) / width) + 0.5 * std::exp(v * x / d) * std::erfc((x + v * days) / width);
      const std::size_t cell = layers - 1 - static_cast<std::size_t>(x / size);
      worst = std::max(worst, std::abs(solutes.concentration(0, cell, water.contentOf(cell)) - expected));
    }
    return worst;
  };
  const double coarse = errorOf(1.0);
  const double fine = errorOf(0.5);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, 0.4 * coarse);
}

}  // namespace
}  // namespace espalier::environment::soil_benchmarks_test
