#include "engine/turtle/world.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace espalier::turtle::world_test {
namespace {

TEST(World, AMomentHasAnOffsetFromUniversalTime) {
  EXPECT_EQ(*julianDayOf("2000-01-01T12:00"), 2451545.0);
  EXPECT_EQ(*julianDayOf("2000-01-01T12:00Z"), 2451545.0);
  EXPECT_EQ(*julianDayOf("2000-01-01T14:00+02:00"), 2451545.0);
  EXPECT_EQ(*julianDayOf("2000-01-01 06:30:00-05:30"), 2451545.0);
  EXPECT_EQ(*julianDayOf("1999-12-31T24:00"), 2451544.5);
  EXPECT_EQ(*julianDayOf("2024-02-29"), *julianDayOf("2024-03-01") - 1);
  for (const char* const noDay : {"2026-02-29", "2026-02-31", "2026-04-31", "1900-02-29", "2026-12-32", "2026-01-00"}) {
    EXPECT_FALSE(julianDayOf(noDay)) << noDay;
  }
  for (const char* text : {"2000-01-01T12:00+2", "2000-01-01T12:00+02", "2000-01-01T12:00+02:60", "2000-01-01T12:00 ",
                           "2000-01-01T12:00+16:00", "2000-13-01", "2000-01-01+02:00", "2000-01-01T24:01"}) {
    EXPECT_FALSE(julianDayOf(text).has_value()) << text;
  }
}

TEST(World, DatesDifferByWholeSeconds) {
  // 2000-01-01T12:00Z is the Julian day 2451545
  EXPECT_EQ(secondsOfDate("2000-01-01T12:00"), std::int64_t{2451545} * 86400 + 43200);
  EXPECT_EQ(*secondsOfDate("2000-01-01T00:00:07+00:30") - *secondsOfDate("1999-12-31"), 86400 - 1800 + 7);
  EXPECT_EQ(*secondsOfDate("2026-06-21T07:00+02:00") - *secondsOfDate("2026-06-21T04:00Z"), 3600);
  EXPECT_EQ(secondsOfDate("2026-06-21T06:00:00.000Z"), secondsOfDate("2026-06-21T06:00"));
  EXPECT_EQ(secondsOfDate("2026-06-21T06:00:07.9+01:00"), secondsOfDate("2026-06-21T05:00:07Z"));
  EXPECT_FALSE(secondsOfDate("2026-06-21T06:00:07.Z").has_value());
  EXPECT_FALSE(secondsOfDate("2026-06-21T06:00.5Z").has_value());
  EXPECT_EQ(*secondsOfDate("9999-12-31") - *secondsOfDate("0001-01-01"), std::int64_t{3652058} * 86400);
}

TEST(World, StepsThatDivideTheDayEndWithIt) {
  for (std::uint64_t parts = 1; parts <= 1500; ++parts) {
    const double duration = 1.0 / static_cast<double>(parts);
    for (std::uint64_t day = 1; day < 4000; day += 93) {
      EXPECT_EQ(beginOfStep(duration, day * parts), static_cast<double>(day)) << parts;
    }
  }
  // decimals and multiples are the nearest doubles, not sums
  EXPECT_EQ(beginOfStep(0.1, 3), 0.3);
  EXPECT_EQ(beginOfStep(0.7, 30), 21.0);
  EXPECT_EQ(beginOfStep(1.0 / 86400, 86400 * 365 + 1), (86400.0 * 365 + 1) / 86400);
  EXPECT_EQ(beginOfStep(1e-6, 3'000'000), 3.0);
  EXPECT_EQ(beginOfStep(365.25, 4), 1461.0);
  // a number that is no fraction of small numbers is multiplied
  EXPECT_EQ(beginOfStep(0.12345678901234567, 7), 7 * 0.12345678901234567);
  EXPECT_EQ(beginOfStep(5e-324, 3), 3 * 5e-324);
  EXPECT_EQ(beginOfStep(1e300, 3), 3e300);
}

TEST(World, AStepEndsWhereTheNextOneBegins) {
  for (const double duration : {1.0 / 24, 1.0 / 49, 0.1, 1.0 / 7, 2.0, 0.12345678901234567}) {
    double day = 0.0;
    for (std::uint64_t step = 1; step <= 2000; ++step) {
      day = endOfStep(day, duration);
      EXPECT_EQ(day, beginOfStep(duration, step)) << duration;
    }
  }
  EXPECT_EQ(endOfStep(0.35, 0.1), 0.35 + 0.1) << "no step begins then";
}

TEST(World, WhatCannotBeHasASentence) {
  EXPECT_FALSE(problemOfWorld({}).has_value());
  const auto problem = [](auto change) {
    World world;
    change(world);
    return problemOfWorld(world).value_or("none");
  };
  EXPECT_EQ(problem([](World& w) { w.up = {0, 0, 0}; }), "'up' has no direction; give a vector such as [0, 1, 0]");
  EXPECT_EQ(problem([](World& w) {
              w.north = {0, 2, 0};
            }),
            "'north' is along 'up' or has no direction (left out it is [0, 0, -1]); give a horizontal vector such as "
            "[0, 0, -1]");
  EXPECT_EQ(problem([](World& w) {
              w.up = {0, 0, 1};
            }),
            "'north' is along 'up' or has no direction (left out it is [0, 0, -1]); give a horizontal vector such as "
            "[0, 1, 0]");
  EXPECT_EQ(problem([](World& w) { w.stepDurationDays = std::numeric_limits<double>::quiet_NaN(); }),
            "'stepDuration' must be greater than 0; give a number of days, or a text such as \"1 h\"");
  EXPECT_EQ(problem([](World& w) { w.stepDurationDays = 1e300; }),
            "'stepDuration' must be at most 1000000 days; give a number of days, or a text such as \"1 h\"");
  EXPECT_EQ(problem([](World& w) { w.latitudeDegrees = 90.5; }),
            "'latitude' must lie between -90 and 90 degrees, north positive");
  EXPECT_EQ(problem([](World& w) { w.start = "yesterday"; }),
            "'start' is no date: 'yesterday'; write for example 2026-06-21T06:00+02:00");
}

}  // namespace
}  // namespace espalier::turtle::world_test
