#include <gtest/gtest.h>

#include <cmath>

#include "engine/core/elementary.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::insects_test {
namespace {

TEST(Insects, ShareTheOfferOnWhichTheySit) {
  // one offer in reach: all sit on it, and eat what is there or what they want
  const auto process = openProcess("insects", R"({"count":4,"appetite":0.5,"reach":2})");
  auto row = answersOf(*process, QueryBuilder().add({1, 2, 3}, {10, 0}).batch())[0];
  EXPECT_EQ(row[0], 2.0);
  EXPECT_EQ(row[1], 4.0);
  row = answersOf(*process, QueryBuilder().add({1, 2, 3}, {1.5, 0}).batch())[0];
  EXPECT_EQ(row[0], 1.5);
}

TEST(Insects, EatByTheTimeOfAStep) {
  turtle::EnvironmentContext context;
  context.world.stepDurationDays = 0.25;
  const auto process = openProcess("insects", R"({"count":4,"appetite":0.5,"reach":2})", context);
  EXPECT_EQ(answersOf(*process, QueryBuilder().add({1, 2, 3}, {10, 0}).batch())[0][0], 0.5);
}

TEST(Insects, SettleWhereThereIsMoreFood) {
  const auto process = openProcess("insects", R"({"count":20000,"appetite":0})");
  const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0}).add({9, 0, 0}, {3, 0}).batch());
  EXPECT_EQ(*table[0][1] + *table[1][1], 20000);
  // a quarter of them, with a standard deviation of 61
  EXPECT_NEAR(*table[0][1], 5000, 250);
}

TEST(Insects, WalkByTheMeanShiftAndNoFurtherThanTheirSpeed) {
  // all begin at 0; then food at 0 and, in reach at 1, three times as much: the mean shift is 3w/(1 + 3w), w = e^(−2/4)
  const double weight = 3 * core::exp(-0.5);
  const double shift = weight / (1 + weight);
  for (const double speed : {10.0, 0.2}) {
    const auto process =
        openProcess("insects", R"({"count":1,"appetite":0,"reach":2,"speed":)" + std::to_string(speed) + "}");
    answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0}).batch());
    answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0}).add({1, 0, 0}, {3, 0}).batch());
    // offers around the place where it must be now: it sits on the nearest
    const double place = std::min(shift, speed);
    const auto table = answersOf(*process, QueryBuilder()
                                               .add({place - 0.02, 0, 0}, {1, 0})
                                               .add({place, 0, 0}, {1, 0})
                                               .add({place + 0.02, 0, 0}, {1, 0})
                                               .batch());
    EXPECT_EQ(table[1][1], 1.0) << speed;
  }
}

TEST(Insects, NoticeFoodInReachOnEverySide) {
  // an insect at a corner of space, then its food just within and just beyond its reach, in 27 directions
  for (int direction = 0; direction < 27; ++direction) {
    const core::Vec3 side{direction % 3 - 1.0, direction / 3 % 3 - 1.0, direction / 9 - 1.0};
    const core::Vec3 start{-0.1, 4.05, 7.9};
    for (const double distance : {1.99, 2.01}) {
      const auto process = openProcess("insects", R"({"count":1,"reach":2,"appetite":0})");
      answersOf(*process, QueryBuilder().add(start, {1, 0}).batch());
      const core::Vec3 place = start + core::normalised(side) * distance;
      const bool isNoticed = distance < 2 || direction == 13;
      EXPECT_EQ(answersOf(*process, QueryBuilder().add(place, {1, 0}).batch())[0][1], isNoticed ? 1.0 : 0.0)
          << direction;
    }
  }
}

TEST(Insects, WithoutFoodNobodyIsThere) {
  const auto process = openProcess("insects", R"({"count":3,"reach":0.5})");
  const auto row = answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 7}).batch())[0];
  EXPECT_EQ(row[0], 0.0);
  EXPECT_EQ(row[1], 0.0);
}

TEST(Insects, AnInsectThatNoticesNothingWanders) {
  const auto process = openProcess("insects", R"({"count":1,"reach":0.5,"speed":3})");
  answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0}).batch());
  const std::string before = process->save();
  // its food is gone
  answersOf(*process, QueryBuilder().add({50, 0, 0}, {1, 0}).batch());
  EXPECT_NE(process->save(), before);
}

}  // namespace
}  // namespace espalier::environment::insects_test
