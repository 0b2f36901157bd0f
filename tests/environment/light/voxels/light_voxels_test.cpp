#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/turtle/field.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::light_voxels_test {
namespace {

/// A stand of one square metre ground that repeats itself: layers of leaves of `area` in all, evenly in the height 0
/// … 1.
QueryBuilder slab(double area, int layers, std::size_t parameterCount = 5) {
  QueryBuilder builder;
  for (int layer = 0; layer < layers; ++layer) {
    std::vector<double> parameters(parameterCount, 0.0);
    parameters[0] = area / layers;
    builder.add({0.5, (layer + 0.5) / layers, 0.5}, parameters);
  }
  return builder;
}

std::string slabConfiguration(const std::string& more) {
  return R"({"method":"turbid","gridSize":[1,1,1],"voxelSize":1,"position":[0,0,0],"periodic":true,)" + more + "}";
}

TEST(LightVoxels, LightDecreasesInASlabByTheLawOfBeerAndLambert) {
  // a homogeneous layer of leaf area index L: light from the angle θ arrives with exp(−G(θ) L/cos θ) below it and with
  // exp(−G L (1 − h)/cos θ) at the height h. Spherical: G = 1/2
  for (const double cosine : {1.0, 0.8, 0.28}) {
    const double sine = std::sqrt(1 - cosine * cosine);
    const auto process = openProcess(
        "light-voxels", slabConfiguration(R"("directions":[[)" + std::to_string(sine * 0.6) + "," +
                                          std::to_string(cosine) + "," + std::to_string(sine * 0.8) + ",3]]"));
    auto builder = slab(2.5, 1);
    builder.add({0.5, 0, 0.5}, {0}).add({-7.3, 0.75, 12.1}, {0}).add({3, 1.5, 0}, {0});
    const auto light = firstValues(answersOf(*process, builder.batch()));
    EXPECT_NEAR(light[1], std::exp(-0.5 * 2.5 / cosine), 1e-6) << cosine;
    EXPECT_NEAR(light[2], std::exp(-0.5 * 2.5 * 0.25 / cosine), 1e-6) << cosine;
    EXPECT_EQ(light[3], 1.0);
  }
}

TEST(LightVoxels, AUniformSkyThroughASlabGivesTheThirdExponentialIntegral) {
  // ∫ exp(−k/μ) 2μ dμ = 2 E₃(k), with E₃(0.5) = 0.22160437 and E₃(1) = 0.10969197 (Abramowitz & Stegun, table 5.4)
  for (const auto& [area, expected] : {std::pair(1.0, 2 * 0.22160437), std::pair(2.0, 2 * 0.10969197)}) {
    const auto process = openProcess("light-voxels", slabConfiguration(R"("sky":"uniform","zenithAngles":12)"));
    auto builder = slab(area, 1);
    builder.add({0.5, 0, 0.5}, {0});
    EXPECT_NEAR(firstValues(answersOf(*process, builder.batch()))[1], expected, 1e-5);
  }
}

TEST(LightVoxels, TheLeavesOfASlabAbsorbWhatTheLightLoses) {
  // Σ area · p5 over the leaves is 1 − T: the sum of p5 is the midpoint rule of ∫ −dI, here with 400 points
  for (const std::string angles : {"spherical", "planophile", "erectophile", "vertical"}) {
    const auto process = openProcess(
        "light-voxels", slabConfiguration(R"("irradiance":400,"absorptance":0.81,"leafAngles":")" + angles + "\""));
    auto builder = slab(3, 400);
    builder.add({0.5, 0, 0.5}, {0});
    const auto table = answersOf(*process, builder.batch());
    double absorbed = 0;
    for (std::size_t leaf = 0; leaf < 400; ++leaf) {
      absorbed += 3.0 / 400 * *table[leaf][4];
    }
    const double below = *table[400][0];
    EXPECT_GT(below, 20);
    EXPECT_LT(below, 120);
    EXPECT_NEAR((400 - below) / absorbed, 1, 1e-4) << angles;
  }
}

TEST(LightVoxels, ScatteringLeavesLetLightPassByTheRootOfTheirAbsorptance) {
  // Goudriaan (1977): leaves that absorb α dim the light like black ones of √α of their area
  const auto below = [](double area, double absorptance) {
    const auto process = openProcess(
        "light-voxels", slabConfiguration(R"("directions":[[0,1,0,1]],"absorptance":)" + std::to_string(absorptance)));
    auto builder = slab(area, 1);
    builder.add({0.5, 0, 0.5}, {0});
    return firstValues(answersOf(*process, builder.batch()))[1];
  };
  EXPECT_NEAR(below(2, 0.64), std::exp(-0.5 * 0.8 * 2), 1e-12);
  EXPECT_EQ(below(2, 0), 1.0);
}

TEST(LightVoxels, TheGradientPointsToTheLightBesideACanopy) {
  // leaves fill the half x < 0 of a box that ends at x = 0: outside of it there is nothing
  const auto process = openProcess("light-voxels", R"({"gridSize":[20,20,20],"voxelSize":0.5,"position":[-10,0,-5]})");
  QueryBuilder builder;
  for (int i = 0; i < 8000; ++i) {
    builder.add({-9.75 + 0.5 * (i % 20), 0.25 + 0.5 * (i / 20 % 20), -4.75 + 0.5 * (i / 400)}, {0.1});
  }
  builder.add({-0.6, 5, 0}, {0, 0, 0, 0});
  const auto answer = answersOf(*process, builder.batch()).back();
  EXPECT_GT(*answer[1], 0);
  EXPECT_GT(*answer[2], 0);
  EXPECT_GT(*answer[1], 10 * std::abs(*answer[3]));
}

TEST(LightVoxels, ABudDoesNotShadeItselfAndShadesThePyramidBelow) {
  // one caster: s = a·b^−q in tier q; a = 0.2, b = 2
  const auto process = openProcess(
      "light-voxels", R"({"method":"shadow","gridSize":[9,9,9],"voxelSize":1,"position":[0,0,0],"shadowDepth":3})");
  const auto shadow = [](int q) { return 0.2 * std::pow(2.0, -q); };
  QueryBuilder builder;
  builder.add({4.5, 7.5, 4.5}, {1, 0, 0, 0});
  for (const core::Vec3& place :
       {core::Vec3{4.5, 6.5, 4.5}, core::Vec3{5.1, 6.2, 3.9}, core::Vec3{6.5, 6.5, 4.5}, core::Vec3{6.5, 5.5, 2.5},
        core::Vec3{4.5, 4.5, 4.5}, core::Vec3{4.5, 3.5, 4.5}, core::Vec3{4.5, 8.5, 4.5}, core::Vec3{4.5, 7.5, 5.5}}) {
    builder.add(place, {0, 0, 0, 0});
  }
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(firstValues(table),
            (std::vector<double>{1, 1 - shadow(1), 1 - shadow(1), 1, 1 - shadow(2), 1 - shadow(3), 1, 1, 1}));
  // V = −∇s: at the caster up to the light, (s(above) − s(below))/2 negated; left of the axis of the pyramid to the
  // left
  EXPECT_DOUBLE_EQ(*table[0][2], shadow(1) / 2);
  EXPECT_EQ(*table[0][1], 0);
  EXPECT_DOUBLE_EQ(*table[1][2], (shadow(2) - shadow(0)) / 2);
  EXPECT_DOUBLE_EQ(*table[4][1], shadow(2) / 2);
  EXPECT_DOUBLE_EQ(*table[4][3], -shadow(2) / 2);
}

TEST(LightVoxels, PropagatedShadowsAgreeWithAddingThemOneByOne) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(0.0, 6.0);
  for (const bool isPeriodic : {false, true}) {
    for (const int up : {1, -1, 2}) {
      turtle::EnvironmentContext context;
      context.world.up = up == 2 ? core::Vec3{0, 0, 1} : core::Vec3{0, static_cast<double>(up), 0};
      const auto process = openProcess("light-voxels",
                                       R"({"method":"shadow","gridSize":[6,6,6],"voxelSize":1,"position":[0,0,0],)"
                                       R"("fullLight":30,"shadowDepth":7,"periodic":)" +
                                           std::string(isPeriodic ? "true}" : "false}"),
                                       context);
      QueryBuilder builder;
      for (int i = 0; i < 40; ++i) {
        builder.add({place(random), place(random), place(random)}, {static_cast<double>(i % 3)});
      }
      const auto light = firstValues(answersOf(*process, builder.batch()));
      const auto& positions = builder.batch().position;
      for (std::size_t i = 0; i < 40; ++i) {
        double expected = 30.0 + 0.2 * static_cast<double>(i % 3);
        for (std::size_t k = 0; k < 40; ++k) {
          const auto cell = [&](double here, double there) { return std::floor(here) - std::floor(there); };
          const double dx = cell(positions[i].x, positions[k].x);
          const double dy = cell(positions[i].y, positions[k].y);
          const double dz = cell(positions[i].z, positions[k].z);
          const double q = up == 2 ? -dz : -up * dy;
          const double side = up == 2 ? dy : dz;
          const int copies = isPeriodic ? 3 : 0;
          for (int m = -copies; m <= copies; ++m) {
            for (int n = -copies; n <= copies; ++n) {
              if (q >= 0 && q <= 7 && std::abs(dx + 6 * m) <= q && std::abs(side + 6 * n) <= q) {
                expected -= static_cast<double>(k % 3) * 0.2 * std::pow(2.0, -q);
              }
            }
          }
        }
        EXPECT_NEAR(light[i], expected, 1e-12) << "up " << up << " periodic " << isPeriodic;
      }
    }
  }
}

TEST(LightVoxels, FieldsShowWhatQueriesSee) {
  for (const std::string method : {"turbid", "shadow"}) {
    const auto process = openProcess(
        "light-voxels", R"({"gridSize":[2,3,4],"voxelSize":1,"position":[0,0,0],"method":")" + method + "\"}");
    QueryBuilder builder;
    builder.add({0.5, 2.5, 1.5}, {2}).add({0.5, 1.5, 1.5}, {0});
    const auto light = firstValues(answersOf(*process, builder.batch()));
    const auto fields = process->fields();
    ASSERT_EQ(fields.size(), 2U);
    EXPECT_EQ(fields[0].cells, (std::array<std::size_t, 3>{2, 3, 4}));
    // x fastest, then y, then z: cell (0, 1, 1) is number 8, the leaf's is number 10
    EXPECT_EQ(fields[0].values[8], light[1]);
    EXPECT_LT(fields[0].values[8], 1.0);
    EXPECT_EQ(fields[1].values[10], 2.0);
  }
}

TEST(LightVoxels, LightIsNeverNegative) {
  const auto process = openProcess("light-voxels", R"({"method":"shadow","gridSize":[3,3,3],"position":[0,0,0]})");
  QueryBuilder builder;
  for (int i = 0; i < 20; ++i) {
    builder.add({0.7, 1.2, 0.7}, {1});
  }
  builder.add({0.7, 0.7, 0.7}, {0}).add({90, 0.7, 0.7}, {1});
  const auto light = firstValues(answersOf(*process, builder.batch()));
  EXPECT_EQ(light[0], 0.0);
  EXPECT_EQ(light[20], 0.0);
  EXPECT_EQ(light[21], 1.0) << "outside the box nothing casts";
}

TEST(LightVoxels, WhatCannotBeIsAnError) {
  turtle::EnvironmentContext context;
  context.world.up = {0, 1, 1};
  auto made = makeProcess("light-voxels", "");
  EXPECT_EQ(made.value()->open(context)->message,
            "Environment 'light-voxels' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
  made = makeProcess("light-voxels", R"({"directions":[[1,0,0,1]]})");
  EXPECT_EQ(made.value()->open({})->message,
            "Environment 'light-voxels' takes light from above only: in 'directions' every direction must be above the "
            "horizon and no weight below 0.");
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"gridSize":[4096,4096,4096]})")),
            "error: environment process 'light-voxels': the grid has 68719476736 cells, and the limit is 134217728\n"
            "   hint: use fewer cells along x, y or z");
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"sensor":"fluxes"})")),
            "error: environment process 'light-voxels': a 'sensor' of fluxes needs 'scattering'\n"
            "   hint: write \"scattering\": true");
}

TEST(LightVoxels, AStepThatFollowsAnotherAnswersLikeANewProcessBitByBit) {
  for (const std::string more : {"", R"(,"periodic":true)", R"(,"periodic":true,"gridSize":[13,16,13])"}) {
    const std::string configuration = R"({"voxelSize":0.5,"position":[0,0,0],"zenithAngles":3)" + more +
                                      (more.find("gridSize") == std::string::npos ? R"(,"gridSize":[16,16,16]})" : "}");
    const auto following = openProcess("light-voxels", configuration);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> place(-1.0, 9.0);  // of the box from 0 to 8, and around it
    std::vector<core::Vec3> places;
    std::vector<double> areas;
    for (int i = 0; i < 200; ++i) {
      places.push_back({place(random), place(random), place(random)});
      areas.push_back(i % 3 == 0 ? 0.0 : 0.1);
    }
    for (int step = 0; step < 8; ++step) {
      // nothing, one leaf, a few, many; leaves grow, move, come and go
      for (int change = 0; change < (step % 2 == 0 ? 0 : step); ++change) {
        const std::size_t organ = random() % places.size();
        areas[organ] += 0.01;
        places[random() % places.size()] = {place(random), place(random), place(random)};
      }
      if (step == 6) {
        places.erase(places.begin() + 40, places.begin() + 60);
        areas.erase(areas.begin() + 40, areas.begin() + 60);
      }
      QueryBuilder builder;
      for (std::size_t i = 0; i < places.size(); ++i) {
        std::vector<double> parameters((i + static_cast<std::size_t>(step)) % 2 == 0 ? 5U : 1U, 0.0);
        parameters[0] = areas[i];
        builder.add(places[i], parameters);
      }
      EXPECT_EQ(answersOf(*following, builder.batch()),
                answersOf(*openProcess("light-voxels", configuration), builder.batch()))
          << "step " << step << " " << configuration;
    }
  }
}

}  // namespace
}  // namespace espalier::environment::light_voxels_test
