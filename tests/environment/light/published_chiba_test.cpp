// The worked examples of recorded runs of the published program, and what follows from them.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_chiba_test {
namespace {

/// Light of spheres of one radius in the compatible variant.
std::vector<double> lightOf(const std::vector<core::Vec3>& places, double radius, const std::string& more) {
  const auto process = openProcess("chiba", R"({"compatible":true,"transmittance":0.5,)" + more + "}");
  QueryBuilder builder;
  for (const core::Vec3& place : places) {
    builder.add(place, {radius});
  }
  return firstValues(answersOf(*process, builder.batch()));
}

std::string cubes(int size) {
  const std::string n = std::to_string(size);
  return R"("gridSize":[)" + n + "," + n + "," + n + "]";
}

TEST(PublishedChiba, TheGridDecidesWhichSpheresARayMeets) {
  const std::vector<core::Vec3> three{{1, 1, 1}, {3, 3, 3}, {-2, 5, 2}};
  const std::string diagonal = R"("sources":[[1,1,1,1]])";
  EXPECT_EQ(lightOf(three, 1, diagonal), (std::vector<double>{0.5, 1, 1}));
  for (const auto& [size, light] : std::map<int, double>{{1, 0.5}, {2, 0.5}, {4, 0.5}, {8, 1}, {16, 1}}) {
    EXPECT_EQ(lightOf(three, 1, diagonal + "," + cubes(size)), (std::vector<double>{light, 1, 1})) << size;
  }
}

TEST(PublishedChiba, AGridMayHaveMoreThanTwoHundredVoxelsASide) {
  const std::vector<core::Vec3> pair{{0, 0, 0}, {0, 3, 0}};
  const std::string up = R"("sources":[[0,1,0,1]],)";
  EXPECT_EQ(lightOf(pair, 1, up + R"("gridSize":[1,1000,1])"), lightOf(pair, 1, up + R"("gridSize":[1,1,1])"));
  EXPECT_NE(errorsOf(makeProcess("chiba", R"({"compatible":true,"gridSize":[1000,1000,1000]})"))
                .find("the limit is 100000000"),
            std::string::npos);
}

TEST(PublishedChiba, ASlantedRowIsMetOrMissedByTheGrid) {
  const std::vector<core::Vec3> four{{10, 10, 0}, {13, 14, 0}, {16, 18, 0}, {12, 22, 0}};
  const std::map<int, std::vector<double>> expected{
      {2, {0.5, 1, 1, 1}}, {4, {0.5, 0.5, 1, 1}}, {8, {1, 1, 1, 1}}, {16, {1, 1, 1, 1}}};
  for (const auto& [size, light] : expected) {
    EXPECT_EQ(lightOf(four, 1, R"("sources":[[3,4,0,1]],)" + cubes(size)), light) << size;
  }
}

TEST(PublishedChiba, AnAreaThatRoundsToNoNumberTakesNoLight) {
  // along (1, 2, 2)/3 the squared distance of the axis rounds below 0 for (5, 10, 10), and not for (3, 6, 6)
  const std::string more = R"("sources":[[1,2,2,1]],"estimateIntersectionArea":true)";
  EXPECT_EQ(lightOf({{0, 0, 0}, {5, 10, 10}}, 0.5, more)[0], 1.0);
  EXPECT_EQ(lightOf({{100, 0, 0}, {103, 6, 6}}, 0.5, more)[0], 0.5);
}

TEST(PublishedChiba, DiscsAtOneHeightShadeEachOther) {
  // equal discs of radius 1 at distance 1 across the light: common area 2·(π/3 − √3/4); below nothing counts
  const std::string more = R"("sources":[[0,1,0,1]],"estimateIntersectionArea":true)";
  const double common = 2.0 * (std::numbers::pi / 3.0 - std::sqrt(3.0) / 4.0) / std::numbers::pi;
  const auto light = lightOf({{0, 0, 0}, {1, 0, 0}, {9, 3, 0}, {9, 0, 0}}, 1, more);
  EXPECT_NEAR(light[0], 1.0 - 0.5 * common, 1e-6);
  EXPECT_NEAR(light[1], 1.0 - 0.5 * common, 1e-6);
  EXPECT_EQ(light[2], 1.0);
  EXPECT_NEAR(light[3], 0.5, 1e-7);
}

TEST(PublishedChiba, WithoutAGridThereIsOneVoxelAndChordsAreRight) {
  // a sphere whose middle is 0.6 aside of the ray: chord 1.6 of 2; one around the point: what is ahead of it
  const std::string up = R"("sources":[[0,1,0,1]])";
  EXPECT_NEAR(lightOf({{0, 0, 0}, {0.6, 3, 0}}, 1, up)[0], std::pow(0.5, 0.8), 1e-6);
  EXPECT_NEAR(lightOf({{0, 0, 0}, {0, 0.5, 0}}, 1, up)[0], std::pow(0.5, 0.75), 1e-6);
  EXPECT_NEAR(lightOf({{0, 0, 0}, {0, 0.5, 0}}, 1, up)[1], std::pow(0.5, 0.25), 1e-6);
}

TEST(PublishedChiba, QueriesWithNoneTwoOrThreeParametersAreLeftOut) {
  const auto process = openProcess("chiba", R"({"compatible":true,"sources":[[0,1,0,1]]})");
  const auto table = answersOf(*process, QueryBuilder()
                                             .add({0, 0, 0}, {1})
                                             .add({0, 5, 0}, {1, 0})
                                             .add({0, 6, 0}, {1, 0, 0})
                                             .add({0, 7, 0}, {})
                                             .add({0, -9, 0}, {1, 9, 9, 9, 9})
                                             .batch());
  EXPECT_EQ(table[0][0], 1.0);
  EXPECT_EQ(table[1][0], std::nullopt);
  EXPECT_EQ(table[2][0], std::nullopt);
  EXPECT_NE(table[4][0], 1.0);
  EXPECT_EQ(table[4][2], 1.0);
  EXPECT_EQ(table[4][4], std::nullopt);
}

TEST(PublishedChiba, TheUniformSkyHasTheRatioBetweenItsHalves) {
  // a wide sphere above takes its part of the upper half only: with ratio 3 the lower half has 3/4 of the light
  const auto process = openProcess("chiba", R"({"compatible":true,"lowerToUpperRatio":3,"transmittance":0})");
  const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {1}).add({0, 1001, 0}, {1000}).batch());
  EXPECT_NEAR(*table[0][0], 0.75, 1e-6);
}

}  // namespace
}  // namespace espalier::environment::published_chiba_test
