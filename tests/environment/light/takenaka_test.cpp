#include <gtest/gtest.h>

#include <cmath>

#include "tests/environment/query_builder.h"

namespace espalier::environment::takenaka_test {
namespace {

turtle::EnvironmentContext centimetres() {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  return context;
}

// s = 1.5, t = 0.1: (1 - t)/s² = 0.4, a ball lets pass 0.6² = 0.36 and takes 0.64
constexpr double kFull = 0.015 * 100.0 / 4.0 * 2.25 * 0.64;

double productUnder(const std::string& configuration, const core::Vec3& other, double area,
                    const turtle::EnvironmentContext& context) {
  const auto process = openProcess("takenaka", configuration, context);
  const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {100, 0.1}).add(other, {area, 0}).batch());
  EXPECT_EQ(table[0][0], 100.0);
  return *table[0][1];
}

TEST(Takenaka, AFullyLitBallMakesItsShareOfAYearsLight) {
  // 1000 µmol m^-2 s^-1 · 12 h · 200 days = 8640 mol m^-2 = 0.864 mol cm^-2
  EXPECT_NEAR(productUnder("", {500, 0, 0}, 1, centimetres()), kFull * 0.864 - 0.1, 1e-12);
  EXPECT_NEAR(productUnder("", {500, 0, 0}, 1, {}), kFull * 8640 - 0.1, 1e-9);
}

TEST(Takenaka, EveryBallOnTheWayLetsPassItsPart) {
  // the radius of the ball above, area 100: 1.5/2·√(100/π) = 4.2314
  const double radius = 0.75 * std::sqrt(100.0 / 3.14159265358979);
  EXPECT_NEAR(productUnder("", {0, 50, 0}, 100, centimetres()), kFull * 0.864 * 0.36 - 0.1, 1e-12);
  EXPECT_NEAR(productUnder("", {radius - 0.01, 50, 0}, 100, centimetres()), kFull * 0.864 * 0.36 - 0.1, 1e-12);
  EXPECT_NEAR(productUnder("", {radius + 0.01, 50, 0}, 100, centimetres()), kFull * 0.864 - 0.1, 1e-12);
  EXPECT_NEAR(productUnder("", {0, -50, 0}, 100, centimetres()), kFull * 0.864 - 0.1, 1e-12);
}

TEST(Takenaka, BallsBeyondASourceDoNotCount) {
  const std::string sources = R"("sources":[[0,20,0,5]])";
  EXPECT_NEAR(productUnder("{" + sources + "}", {0, 50, 0}, 100, centimetres()), kFull * 0.864 - 0.1, 1e-12);
}

TEST(Takenaka, SourcesShareTheLightByTheirWeights) {
  // one of 3 parts above, shaded; one of 1 part to the side, free
  EXPECT_NEAR(productUnder(R"({"sources":[[0,1000,0,3],[1000,0,0,1]]})", {0, 50, 0}, 100, centimetres()),
              kFull * 0.864 * (0.75 * 0.36 + 0.25) - 0.1, 1e-12);
}

TEST(Takenaka, ADiskLightsWhatIsBelowItAndWithinItsRadius) {
  // a disc of radius 5 around (20, 30, 0): its light falls on balls below it that are at most 5 aside
  const std::string disk = R"({"diskSource":[5,20,30,0],"sources":[[0,9,0,1]]})";
  const auto productAt = [&](const core::Vec3& place) {
    const auto process = openProcess("takenaka", disk, centimetres());
    return *answersOf(*process, QueryBuilder().add(place, {100, 0.1}).batch())[0][1];
  };
  EXPECT_NEAR(productAt({20, 0, 0}), kFull * 0.864 - 0.1, 1e-12);
  EXPECT_NEAR(productAt({24, 30, 3}), kFull * 0.864 - 0.1, 1e-12);
  EXPECT_NEAR(productAt({24, 0, 3.01}), -0.1, 1e-12);
  EXPECT_NEAR(productAt({20, 30.01, 0}), -0.1, 1e-12);
  // balls above the disc shade nothing
  const auto process = openProcess("takenaka", disk, centimetres());
  const auto table = answersOf(
      *process, QueryBuilder().add({20, 0, 0}, {100, 0}).add({20, 20, 0}, {100, 0}).add({20, 40, 0}, {100, 0}).batch());
  EXPECT_NEAR(*table[0][1], kFull * 0.864 * 0.36, 1e-12);
  EXPECT_NEAR(*table[1][1], kFull * 0.864, 1e-12);
}

TEST(Takenaka, OtherNumbersOfParametersAreNoBalls) {
  const auto process = openProcess("takenaka", "", centimetres());
  const auto table = answersOf(
      *process, QueryBuilder().add({0, 0, 0}, {100, 0}).add({0, 50, 0}, {100}).add({0, 60, 0}, {100, 0, 0}).batch());
  EXPECT_NEAR(*table[0][1], kFull * 0.864, 1e-12);
  EXPECT_EQ(table[1][0], std::nullopt);
  EXPECT_EQ(table[2][0], std::nullopt);
}

TEST(Takenaka, RefusesLengthUnitsItCannotConvert) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "furlong";
  auto made = makeProcess("takenaka", "");
  const auto error = made.value()->open(context);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "Environment 'takenaka' needs lengths in m, dm, cm or mm, and the world's unit is 'furlong'. Set lengthUnit "
      "to one of these.");
}

}  // namespace
}  // namespace espalier::environment::takenaka_test
