#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::shadow_test {
namespace {

// spacing 1 voxel a length unit: 2 * 50 / (101 - 1)
constexpr const char* kUnitGrid = R"({"gridSize":101,"gridSpan":50})";
constexpr double kC1 = 0.58;
constexpr double kC2 = 6.9;

double factor(double distance) {
  return 1.0 - kC1 * std::pow(kC2, -distance);
}

TEST(Shadow, ReproducesTheNumbersOfConformanceCase195) {
  const auto process = openProcess("shadowpyramid", R"({"gridSize":101,"gridSpan":100})");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({0, 17, 0}, {1}).add({1, 14, 0}, {1}).add({30, 14, 0}, {1}).add({0, 5, 0}, {0});
  const auto first = firstValues(answersOf(*process, builder.batch()));
  const std::vector<double> expected{0.42, 0.665413, 0.658971, 0.42, 0.999865};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(first[i], expected[i], 5e-7) << i;
  }
  builder.batch().parameters.back() = 1;
  EXPECT_NEAR(firstValues(answersOf(*process, builder.batch()))[4], 0.709874, 5e-7);
}

TEST(Shadow, WeakensWithTheEuclideanDistanceInVoxels) {
  // below a caster at (0, 20, 0): straight down d = 1, 2; diagonally in tier 3, two voxels aside, d = sqrt(9 + 4 + 1)
  const auto process = openProcess("shadow", kUnitGrid);
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({0, 19, 0}, {0}).add({0, 18, 0}, {0}).add({2, 17, -1}, {0});
  const auto values = firstValues(answersOf(*process, builder.batch()));
  EXPECT_NEAR(values[0], factor(0), 1e-11);
  EXPECT_NEAR(values[1], factor(1), 1e-11);
  EXPECT_NEAR(values[2], factor(2), 1e-11);
  EXPECT_NEAR(values[3], factor(std::sqrt(14.0)), 1e-11);
}

TEST(Shadow, CoversTiersBelowWithTheirHalfWidthAndNothingElse) {
  // spread 1, depth 3: tier 2 reaches two voxels aside, tier 3 and everything above the caster is free
  const auto process = openProcess("shadow", R"({"gridSize":101,"gridSpan":50,"shadowDepth":3})");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1})
      .add({0, 21, 0}, {0})
      .add({1, 20, 0}, {0})
      .add({2, 18, 2}, {0})
      .add({3, 18, 0}, {0})
      .add({0, 17, 0}, {0});
  const auto values = firstValues(answersOf(*process, builder.batch()));
  EXPECT_EQ(values[1], 1.0);
  EXPECT_EQ(values[2], 1.0);
  EXPECT_NEAR(values[3], factor(std::sqrt(12.0)), 1e-11);
  EXPECT_EQ(values[4], 1.0);
  EXPECT_EQ(values[5], 1.0);
}

TEST(Shadow, ShadowsMultiply) {
  // three casters in one voxel: their own light is (1 - C1)^3
  const auto process = openProcess("shadow", kUnitGrid);
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({0, 20, 0}, {2}).add({0.2, 20, 0}, {0.5});
  EXPECT_NEAR(firstValues(answersOf(*process, builder.batch()))[0], std::pow(1.0 - kC1, 3), 1e-11);
}

TEST(Shadow, LightIsInterpolatedBetweenEightVoxels) {
  // one dark voxel with light a = 1 - C1 and depth 1: at offset (0.25, 0.5, 0) from it the weight of the dark voxel is
  // 0.75 * 0.5, so the light is 1 - 0.375 C1
  const auto process = openProcess("shadow", R"({"gridSize":101,"gridSpan":50,"shadowDepth":1})");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({0.25, 20.5, 0}, {0});
  EXPECT_NEAR(firstValues(answersOf(*process, builder.batch()))[1], 1.0 - 0.375 * kC1, 1e-11);
}

TEST(Shadow, GradientIsTheCentralDifferenceOverTheSampleRadius) {
  // depth 1, one dark voxel at the origin of the query's line: at (1, 20, 0) with radius 1 the samples at x = 2 and x =
  // 0 are 1 and 1 - C1, so d/dx = C1 / 2; above and below, before and behind it is light: 0
  const auto process = openProcess(
      "shadow", R"({"gridSize":101,"gridSpan":50,"shadowDepth":1,"sampleRadius":1,"lightVerticalBias":0.25})");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({1, 20, 0}, {0, 0, 0, 0, 7});
  const auto row = answersOf(*process, builder.batch())[1];
  EXPECT_NEAR(*row[1], kC1 / 2.0, 1e-11);
  EXPECT_NEAR(*row[2], 0.25, 1e-11);
  EXPECT_NEAR(*row[3], 0.0, 1e-11);
  EXPECT_EQ(row[4], std::nullopt);
}

TEST(Shadow, FollowsTheWorldsUp) {
  // the same scene turned so that z is up gives the same light and the turned gradient
  turtle::EnvironmentContext upright;
  turtle::EnvironmentContext turned;
  turned.world.up = {0, 0, 1};
  turtle::EnvironmentContext hanging;
  hanging.world.up = {-1, 0, 0};
  const auto first = openProcess("shadow", kUnitGrid, upright);
  const auto second = openProcess("shadow", kUnitGrid, turned);
  const auto third = openProcess("shadow", kUnitGrid, hanging);
  QueryBuilder a;
  a.add({0, 20, 0}, {1, 0, 0, 0}).add({0.4, 18.3, 0.7}, {0, 0, 0, 0});
  QueryBuilder b;  // grid (x, y, z) is world (x, z, y)
  b.add({0, 0, 20}, {1, 0, 0, 0}).add({0.4, 0.7, 18.3}, {0, 0, 0, 0});
  QueryBuilder c;  // grid (x, y, z) is world (-y, x, z)
  c.add({-20, 0, 0}, {1, 0, 0, 0}).add({-18.3, 0.4, 0.7}, {0, 0, 0, 0});
  const auto rowA = answersOf(*first, a.batch())[1];
  const auto rowB = answersOf(*second, b.batch())[1];
  const auto rowC = answersOf(*third, c.batch())[1];
  EXPECT_LT(*rowA[0], 1.0);
  EXPECT_EQ(rowB, (std::vector<std::optional<double>>{rowA[0], rowA[1], rowA[3], rowA[2]}));
  EXPECT_EQ(rowC, (std::vector<std::optional<double>>{rowA[0], -*rowA[2], rowA[1], rowA[3]}));
}

TEST(Shadow, RefusesAnUpThatIsNotAlongAnAxis) {
  auto made = makeProcess("shadow", "");
  for (const core::Vec3& up : {core::Vec3{1, 1, 0}, core::Vec3{0, 0, 0}}) {
    turtle::EnvironmentContext context;
    context.world.up = up;
    const auto error = made.value()->open(context);
    ASSERT_TRUE(error);
    EXPECT_EQ(error->message, "Environment 'shadow' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
  }
}

TEST(Shadow, DoesNotDependOnTheOrderOfQueriesBitByBit) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-6, 6);
  std::vector<core::Vec3> points;
  for (int i = 0; i < 400; ++i) {
    points.push_back({place(random), 20 + place(random), place(random)});
  }
  const auto run = [&](const std::vector<std::size_t>& order) {
    const auto process = openProcess("shadow", R"({"gridSize":101,"gridSpan":50,"lightRandomness":0.1})");
    QueryBuilder builder;
    for (const std::size_t i : order) {
      builder.add(points[i], {i % 3 == 0 ? 0.0 : 1.0, 0, 0, 0});
      builder.batch().module.back() = i;
    }
    const auto table = answersOf(*process, builder.batch());
    ReplyTable sorted(points.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      sorted[order[k]] = table[k];
    }
    return sorted;
  };
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const ReplyTable expected = run(order);
  for (int round = 0; round < 3; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    EXPECT_EQ(run(order), expected);
  }
}

TEST(Shadow, RandomnessIsBoundedAndGivenBySeedStepAndModule) {
  turtle::EnvironmentContext context;
  context.seed = 1;
  const auto process = openProcess("shadow", R"({"lightRandomness":0.1})", context);
  QueryBuilder builder;
  builder.add({0, 20, 0}, {0, 0, 0, 0}).add({0, 20, 0}, {0, 0, 0, 0});
  const auto table = answersOf(*process, builder.batch());
  for (std::size_t k = 1; k <= 3; ++k) {
    EXPECT_LE(std::fabs(*table[0][k]), 0.1);
    EXPECT_NE(*table[0][k], *table[1][k]);
  }
  EXPECT_EQ(answersOf(*process, builder.batch()), table);
  builder.batch().step = 1;
  EXPECT_NE(answersOf(*process, builder.batch()), table);
}

TEST(Shadow, OutsideTheGridItIsLight) {
  const auto process = openProcess("shadow", kUnitGrid);
  QueryBuilder builder;
  builder.add({1e30, 20, 0}, {1})
      .add({0, -3, 0}, {1})
      .add({-50, 100, 50}, {1})
      .add({0, 103, 0}, {1})
      .add({0, 100, 0}, {0});
  const auto values = firstValues(answersOf(*process, builder.batch()));
  EXPECT_EQ(values[0], 1.0);
  EXPECT_EQ(values[1], 1.0);
  EXPECT_NEAR(values[2], factor(0), 1e-11);
  // a caster above the grid shades the voxels of its pyramid that are inside: tier 3 straight below
  EXPECT_EQ(values[3], 1.0);
  EXPECT_NEAR(values[4], factor(3), 1e-11);
}

TEST(Shadow, FullWeightMakesItDark) {
  const auto process = openProcess("shadow", R"({"shadowWeight":1})");
  QueryBuilder builder;
  builder.add({0, 20, 0}, {1}).add({0, 20, 0}, {1});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{0, 0}));
}

TEST(Shadow, ShadowsDoNotOutlastTheStep) {
  const auto process = openProcess("shadow", kUnitGrid);
  QueryBuilder first;
  first.add({0, 20, 0}, {1});
  answersOf(*process, first.batch());
  QueryBuilder second;
  second.add({0, 19, 0}, {0});
  EXPECT_EQ(firstValues(answersOf(*process, second.batch())), (std::vector<double>{1.0}));
  EXPECT_TRUE(process->save().empty());
}

}  // namespace
}  // namespace espalier::environment::shadow_test
