#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::meadow_test {
namespace {

// density rises by 1 per column of 2: samples at −2, 0 and 2 see neighbouring columns
constexpr const char* kSlope =
    R"({"gridSize":[5,1],"range":[10,10],"position":[0,-5],"lightMap":[[0,51,102,153,204]]})";

TEST(Meadow, AnInsectFeelsTheMeanDensityAndItsGradient) {
  const auto process = openProcess("meadow", kSlope);
  const auto row = answersOf(*process, QueryBuilder().add({5, 0, 0}, std::vector<double>(6, 9.0)).batch())[0];
  // columns of 0.2, 0.4 and 0.6: mean 0.4, rising along x
  EXPECT_NEAR(*row[0], 0.4, 1e-15);
  EXPECT_EQ(*row[1], 1.0);
  EXPECT_EQ(*row[2], 0.0);
  EXPECT_EQ(*row[3], -1.0);
  EXPECT_EQ(*row[4], 0.0);
}

TEST(Meadow, TheNearestInsectWithinTheRadiusIsNamed) {
  const auto process = openProcess("meadow", kSlope);
  QueryBuilder builder;
  const std::vector<double> six(6, 0.0);
  builder.add({1, 0, 0}, six).add({2.5, 0, 0}, six).add({3.5, 0, 0}, six).add({8, 0, 0}, six).add({1, 0, 0}, {0, 0});
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(*table[0][3], 1.0);
  EXPECT_EQ(*table[0][4], 1.5);
  EXPECT_EQ(*table[1][3], 2.0);
  EXPECT_EQ(*table[2][3], 1.0);
  EXPECT_EQ(*table[2][4], -1.0);
  EXPECT_EQ(*table[3][3], -1.0);
  EXPECT_EQ(table[4][0], std::nullopt);
}

TEST(Meadow, PlantsThatAskAddToTheDensityOfTheStep) {
  const auto process = openProcess("meadow", kSlope);
  const auto six = std::vector<double>(6, 0.0);
  const auto table = answersOf(*process, QueryBuilder().add({5, 0, 0}, six).add({5, 3, 0}, {0.5}).batch());
  // all nine samples of the middle column see it: three of them, 0.5 each
  EXPECT_NEAR(*table[0][0], 0.4 + 1.5 / 9.0, 1e-15);
  EXPECT_NEAR(*answersOf(*process, QueryBuilder().add({5, 0, 0}, six).batch())[0][0], 0.4, 1e-15);
}

TEST(Meadow, CompatibleInsectsAreToldByTheirFollowingModule) {
  turtle::EnvironmentContext context;
  context.symbols = {"E", "I"};
  const auto process =
      openProcess("Meadow", R"({"gridSize":[5,1],"range":[10,10],"position":[0,-5],"compatible":true})", context);
  QueryBuilder builder;
  const std::vector<double> six(6, 7.0);
  builder.add({5, 0, 0}, six).add({5.5, 0, 0}, six);
  builder.batch().following = {1, 0};
  builder.batch().followingParameters = {1, 2, 3, 1, 2, 3};
  builder.batch().followingOffset = {0, 3, 6};
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(*table[0][3], -1.0);
  EXPECT_EQ(table[0][4], std::nullopt);
  EXPECT_EQ(table[1][0], std::nullopt);
}

}  // namespace
}  // namespace espalier::environment::meadow_test
