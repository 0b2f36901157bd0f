#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::density_test {
namespace {

TEST(Density, AnotherTipActsByTheSquareOfItsDistanceASourceByItsDistance) {
  // a tip at distance 2: 1/(1 + 4) = 0.2; a sink of -3 at distance 5 (3, 4): -3/(1 + 5) = -0.5
  const auto process = openProcess("density", R"({"onePointValue":true})");
  const auto table =
      answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0}).add({2, 0, 9}, {7, 7}).add({3, 4, 0}, {-3}).batch());
  EXPECT_DOUBLE_EQ(*table[0][0], 0.2 - 0.5);
  EXPECT_EQ(table[1][0], std::nullopt);
  EXPECT_EQ(table[2][0], std::nullopt);
}

TEST(Density, TheSlopeIsTheCentralDifferenceOverTheSamplingWidth) {
  // a tip at (2, 0): rho(0.5) - rho(-0.5) = 1/(1 + 2.25) - 1/(1 + 6.25), down the gradient is away from it: 180 degrees
  const auto process = openProcess("density", R"({"onePointValue":true})");
  const auto row =
      valuesOf(answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0}).add({2, 0, 0}, {0, 0}).batch())[0]);
  EXPECT_DOUBLE_EQ(row[1], 180.0);
  EXPECT_NEAR(row[2], 1.0 / 3.25 - 1.0 / 7.25, 1e-15);
}

TEST(Density, TheAngleGoesFrom0To360AroundThePlane) {
  const auto process = openProcess("density", R"({"onePointValue":true})");
  for (const double degrees : {1.0, 89.0, 133.0, 271.0, 359.0}) {
    // the occupant stands opposite to the direction
    const double radians = (degrees + 180.0) * std::numbers::pi / 180.0;
    // a far occupant: the field is nearly that of a plane, its direction right within a hundredth of a degree
    const core::Vec3 place{300 * std::cos(radians), 300 * std::sin(radians), 0};
    const auto row =
        valuesOf(answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0}).add(place, {0, 0}).batch())[0]);
    EXPECT_NEAR(row[1], degrees, 0.01);
  }
}

TEST(Density, SamplesAroundATipGiveTheSmallestDensityAndTheFittedSlope) {
  // far from a source of strength v at distance D, rho falls by v/D^2 a unit: with v = 1e6 at (-1000, 0) the slope is
  // about 1e6/1001^2 along x and the smallest sample that of the right edge, at distance 1000.5 from the source
  const auto process = openProcess("density", R"({"returnVector":true})");
  const auto row =
      valuesOf(answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0}).add({-1000, 0, 0}, {1e6}).batch())[0]);
  EXPECT_NEAR(row[0], 1e6 / (1.0 + std::hypot(1000.5, 0.5)), 1e-3);
  EXPECT_NEAR(row[1], 1e6 / (1001.0 * 1001.0), 1e-5);
  EXPECT_NEAR(row[2], 0.0, 1e-9);
}

TEST(Density, TheTreeAgreesWithAllPairs) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-60, 60);
  QueryBuilder builder;
  for (int i = 0; i < 6000; ++i) {
    // crowded in one corner, sparse elsewhere
    const double scale = i % 3 == 0 ? 1.0 : 0.1;
    const core::Vec3 position{place(random) * scale, place(random) * scale, 0};
    builder.add(position, i % 17 == 0 ? std::vector<double>{place(random)} : std::vector<double>{0, 0, 0});
  }
  const auto fast =
      answersOf(*openProcess("density", R"({"onePointValue":true,"returnVector":true})"), builder.batch());
  const auto exact =
      answersOf(*openProcess("density", R"({"onePointValue":true,"returnVector":true,"exact":true})"), builder.batch());
  double largest = 0.0;
  double error = 0.0;
  for (std::size_t query = 0; query < fast.size(); ++query) {
    for (std::size_t k = 0; k < fast[query].size(); ++k) {
      if (exact[query][k]) {
        largest = std::max(largest, std::abs(*exact[query][k]));
        error = std::max(error, std::abs(*exact[query][k] - *fast[query][k]));
      }
    }
  }
  EXPECT_LT(error, 1e-6 * largest);
  EXPECT_GT(error, 0.0);
}

TEST(Density, ThePlaneCanBeChosen) {
  const auto process = openProcess("density", R"({"onePointValue":true,"plane":"xz"})");
  const auto table = answersOf(*process, QueryBuilder().add({0, 5, 0}, {0, 0, 0}).add({0, 0, 2}, {0, 0}).batch());
  EXPECT_DOUBLE_EQ(*table[0][0], 0.2);
  EXPECT_DOUBLE_EQ(*table[0][1], 270.0);
}

}  // namespace
}  // namespace espalier::environment::density_test
