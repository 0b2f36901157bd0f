#include <gtest/gtest.h>

#include <cmath>

#include "engine/turtle/weather.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::wind_test {
namespace {

double speedAt(const std::string& configuration, double height) {
  const auto process = openProcess("wind", configuration);
  return *answersOf(*process, QueryBuilder().add({7, height, -3}, {0, 0, 0}).batch())[0][0];
}

TEST(Wind, BlowsAlongItsDirectionWithItsSpeed) {
  const auto process = openProcess("wind", R"({"direction":[3,0,4],"speed":10})");
  const auto table = answersOf(*process, QueryBuilder().add({1, 2, 3}, {0, 0, 0, 5}).add({}, {0}).batch());
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{6.0, 0.0, 8.0, std::nullopt}));
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{6.0}));
}

TEST(Wind, TheLogarithmicProfileGrowsByTheLogarithmOfTheHeight) {
  // d = 2, z0 = 0.5: at h − d = z0·e^k the speed is k/ln(8/0.5) of that at the reference height 10
  const std::string log = R"({"profile":"logarithmic","speed":3,"displacement":2,"roughness":0.5})";
  EXPECT_NEAR(speedAt(log, 10), 3.0, 1e-15);
  EXPECT_NEAR(speedAt(log, 2 + 0.5 * std::exp(1.0)), 3.0 / std::log(16.0), 1e-15);
  EXPECT_EQ(speedAt(log, 2.5), 0.0);
  EXPECT_EQ(speedAt(log, 2.2), 0.0);  // between d and d + z0 the logarithm is negative
  EXPECT_EQ(speedAt(log, -1), 0.0);
}

TEST(Wind, ThePowerProfileGrowsByAPowerOfTheHeight) {
  const std::string power = R"({"profile":"power","speed":3,"exponent":0.5,"referenceHeight":4,"groundHeight":1})";
  EXPECT_DOUBLE_EQ(speedAt(power, 5), 3.0);
  EXPECT_DOUBLE_EQ(speedAt(power, 2), 1.5);
  EXPECT_EQ(speedAt(power, 1), 0.0);
}

TEST(Wind, TheTableIsLinearBetweenItsHeights) {
  const std::string table = R"({"profile":"table","heights":[1,3],"speeds":[2,8]})";
  EXPECT_EQ(speedAt(table, 0), 2.0);
  EXPECT_EQ(speedAt(table, 1.5), 3.5);
  EXPECT_EQ(speedAt(table, 99), 8.0);
}

TEST(Wind, HeightIsAlongTheWorldsUp) {
  turtle::EnvironmentContext context;
  context.world.up = {0, 0, 2};
  const auto process = openProcess("wind", R"({"profile":"table","heights":[0,10],"speeds":[0,10]})", context);
  EXPECT_EQ(*answersOf(*process, QueryBuilder().add({1, 2, 3}, {0}).batch())[0][0], 3.0);
}

TEST(Wind, WrongProfilesAreErrors) {
  EXPECT_EQ(errorsOf(makeProcess("wind", R"({"direction":[0,0,0]})")),
            "error: environment process 'wind': 'direction' must be three numbers that are not all 0\n"
            "   hint: write it as [x, y, z], or leave it out");
  EXPECT_EQ(
      errorsOf(
          makeProcess("wind", R"({"profile":"logarithmic","displacement":9.95,"referenceHeight":10,"roughness":0.1})")),
      "error: environment process 'wind': 'referenceHeight' must be above displacement + roughness, where the wind "
      "begins\n   hint: the usual reference height is 10 m");
  EXPECT_EQ(errorsOf(makeProcess("wind", R"({"profile":"table","heights":[1],"speeds":[]})")),
            "error: environment process 'wind': there are 1 heights and 0 speeds\n"
            "   hint: the table profile needs one speed for each of at least one height");
  EXPECT_EQ(errorsOf(makeProcess("wind", R"({"profile":"table","heights":[2,2],"speeds":[1,1]})")),
            "error: environment process 'wind': 'heights' must be ascending\n   hint: sort them, each with its speed");
}

TEST(Wind, DefaultsAreConvertedToTheWorldsUnit) {
  // 1 m/s at 10 m over a roughness of 0.1 m, whatever the unit of length
  for (const auto& [unit, length] : {std::pair{"m", 1.0}, {"dm", 10.0}, {"cm", 100.0}, {"mm", 1000.0}}) {
    turtle::EnvironmentContext context;
    context.world.lengthUnit = unit;
    const auto process = openProcess("wind", R"({"profile":"logarithmic"})", context);
    const auto speed = answersOf(*process, QueryBuilder().add({0, 2 * length, 0}, {0}).batch())[0][0];
    EXPECT_NEAR(*speed, length * std::log(20.0) / std::log(100.0), 1e-12 * length) << unit;
  }
  // given numbers stay
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  const auto process =
      openProcess("wind", R"({"profile":"logarithmic","speed":3,"displacement":50,"roughness":10})", context);
  EXPECT_NEAR(*answersOf(*process, QueryBuilder().add({0, 150, 0}, {0}).batch())[0][0],
              3.0 * std::log(10.0) / std::log(95.0), 1e-14);
}

TEST(Wind, TheReferenceMustBeAboveTheStillAirInTheWorldsUnit) {
  turtle::EnvironmentContext context;
  const auto process = makeProcess("wind", R"({"profile":"logarithmic","displacement":9.95})");
  const auto error = process.value()->open(context);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "Environment 'wind': 'referenceHeight' must be above displacement + roughness, where the wind begins, in a "
            "world whose unit is 'm'. The usual reference height is 10 m.");
  context.world.lengthUnit = "cm";
  EXPECT_FALSE(process.value()->open(context).has_value());
}

TEST(Wind, TheWeatherBringsTheSpeed) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  context.world.stepDurationDays = 0.5;
  context.world.weather =
      std::make_shared<const turtle::Weather>(*turtle::Weather::read("time,wind\n0,2\n0.5,3\n", ""));
  const auto process = openProcess("wind", "{}", context);
  turtle::QueryBatch queries = QueryBuilder().add({0, 5, 0}, {0, 0, 0}).batch();
  EXPECT_EQ(answersOf(*process, queries)[0][0], 200.0);
  queries.timeDays = 0.5;
  EXPECT_EQ(answersOf(*process, queries)[0][0], 300.0);
  queries.timeDays = 1;
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  EXPECT_EQ(
      process->step(queries, replies)->message,
      "Environment 'wind' needs the weather from day 1 to day 1.5, and the table covers the time from day 0 to day 1 "
      "after the start. Add rows to the table, or make fewer steps.");
}

}  // namespace
}  // namespace espalier::environment::wind_test
