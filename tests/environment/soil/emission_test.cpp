#include <gtest/gtest.h>

#include <cmath>

#include "engine/turtle/field.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::emission_test {
namespace {

double concentrationAt(turtle::EnvironmentProcess& process, const core::Vec3& place) {
  return *answersOf(process, QueryBuilder().add(place, {0}).batch())[0][0];
}

TEST(Emission, APointSourceSpreadsAsTheHeatKernel) {
  // In the plane dc/dt = D∇²c gives c(r, t) = m/(4πDt) · exp(−r²/(4Dt)) for an amount m at t = 0. Cells of 0.1 and a
  // spread √(2Dt) = 0.8: the cells resolve it within a percent of the middle's concentration. One cell layer of height
  // 0.1: amount per volume is amount per area divided by 0.1.
  const auto process = openProcess(
      "emission", R"({"gridSize":[121,121,1],"cellSize":0.1,"position":[-6.05,-6.05,0],"diffusivity":0.032})");
  answersOf(*process, QueryBuilder().add({0, 0, 0}, {5}).batch());
  for (std::uint64_t day = 1; day < 10; ++day) {
    ASSERT_FALSE(process->tick(day).has_value());
  }
  const double dt4 = 4 * 0.032 * 10;
  const double middle = 5 / (3.14159265358979 * dt4) / 0.1;
  for (const double r : {0.0, 0.5, 1.0, 2.0}) {
    EXPECT_NEAR(concentrationAt(*openProcess("emission", ""), {r, 0, 0}), 0.0, 1e-300);
    const std::string state = process->save();
    EXPECT_NEAR(concentrationAt(*process, {r, 0, 0}), middle * std::exp(-r * r / dt4), 0.01 * middle) << r;
    ASSERT_FALSE(process->restore(state).has_value());
  }
}

double totalOf(turtle::EnvironmentProcess& process, int side) {
  // reads every cell of a box of unit cells in one batch, without giving off anything
  QueryBuilder builder;
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        builder.add({x + 0.5, y + 0.5, z + 0.5}, {0});
      }
    }
  }
  double total = 0.0;
  for (const double value : firstValues(answersOf(process, builder.batch()))) {
    total += value;
  }
  return total;
}

TEST(Emission, MatterIsConservedInAClosedBoxAndDecaysByItsRate) {
  for (const double rate : {0.0, 0.25}) {
    const auto process =
        openProcess("emission", R"({"gridSize":[8,8,8],"diffusivity":3,"decayRate":)" + std::to_string(rate) + "}");
    answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {1}).add({7.5, 3.5, 2.5}, {2.5}).batch());
    for (std::uint64_t day = 1; day < 4; ++day) {
      ASSERT_FALSE(process->tick(day).has_value());
    }
    EXPECT_NEAR(totalOf(*process, 8) / (3.5 * std::exp(-rate * 4)), 1.0, 1e-12);
  }
}

TEST(Emission, AnOpenBoxLosesWhatReachesItsSides) {
  const auto process = openProcess("emission", R"({"gridSize":[8,8,8],"diffusivity":3,"border":"open"})");
  answersOf(*process, QueryBuilder().add({4, 4, 4}, {1}).batch());
  const double before = totalOf(*process, 8);
  EXPECT_LT(before, 0.999);
  EXPECT_LT(totalOf(*process, 8), before);
}

TEST(Emission, EveryoneFeelsWhatTheStepBeforeHasLeft) {
  const auto process = openProcess("emission", R"({"gridSize":[4,4,4],"diffusivity":0,"cellSize":2})");
  QueryBuilder builder;
  builder.add({1, 1, 1}, {4}).add({1, 1, 1}, {12}).add({3, 1, 1}, {0});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{0, 0, 0}));
  // 16 in a volume of 8; the gradient between the two cells' neighbours over two cells of 2
  const auto table = answersOf(*process, QueryBuilder().add({1, 1, 1}, {0}).add({3, 1, 1}, {0, 0, 0, 0}).batch());
  EXPECT_EQ(table[0][0], 2.0);
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{0.0, -0.5, 0.0, 0.0}));
}

TEST(Emission, OutsideTheBoxNothingIsFeltNorKept) {
  const auto process = openProcess("emission", R"({"gridSize":[4,4,4],"diffusivity":0})");
  const std::string empty = process->save();
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({-1, 1, 1}, {4}).batch())), std::vector<double>{0});
  EXPECT_EQ(process->save(), empty);
}

TEST(Emission, TheFieldIsItsConcentration) {
  const auto process = openProcess("emission", R"({"gridSize":[4,3,2],"diffusivity":0,"cellSize":2})");
  answersOf(*process, QueryBuilder().add({3, 1, 1}, {16}).batch());
  const auto fields = process->fields();
  ASSERT_EQ(fields.size(), 1U);
  EXPECT_EQ(fields[0].unit, "1/m^3");
  EXPECT_EQ(fields[0].cellSize, (core::Vec3{2, 2, 2}));
  EXPECT_EQ(fields[0].values[1], 2.0);
}

TEST(Emission, ImpossibleTimesAndSizesAreErrors) {
  turtle::EnvironmentContext context;
  context.world.stepDurationDays = 0.0;
  auto made = makeProcess("emission", R"({"diffusivity":1e9,"cellSize":0.01})");
  auto& process = made.value();
  EXPECT_EQ(process->open(context)->message,
            "Environment 'emission' lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.");
  EXPECT_EQ(process->open({})->message,
            "Environment 'emission' would need more than 100000 diffusion steps in a step of 1.000000 days. Use larger "
            "cells, a smaller diffusivity or shorter steps.");
  // 6 · 8000/0.9 steps of 8 million cells
  EXPECT_EQ(makeProcess("emission", R"({"gridSize":[200,200,200],"diffusivity":8000})").value()->open({})->message,
            "Environment 'emission' would take minutes for a step: 53334 diffusion steps of 8000000 cells. Use larger "
            "or fewer cells, a smaller diffusivity or shorter steps.");
  EXPECT_EQ(errorsOf(makeProcess("emission", R"({"gridSize":[4096,4096,4096]})")),
            "error: environment process 'emission': the grid has 68719476736 cells, and the limit is 67108864\n"
            "   hint: use fewer cells along x, y or z");
}

}  // namespace
}  // namespace espalier::environment::emission_test
