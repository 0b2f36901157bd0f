#include "engine/turtle/world.h"

#include <gtest/gtest.h>

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
                           "2000-01-01T12:00+16:00", "2000-13-01", "2000-01-01+02:00"}) {
    EXPECT_FALSE(julianDayOf(text).has_value()) << text;
  }
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
            "'north' is along 'up' or has no direction; give a horizontal vector such as [0, 0, -1]");
  EXPECT_EQ(problem([](World& w) { w.stepDurationDays = std::numeric_limits<double>::quiet_NaN(); }),
            "'stepDuration' must be greater than 0; give a number of days, or a text such as \"1 h\"");
  EXPECT_EQ(problem([](World& w) { w.latitudeDegrees = 90.5; }),
            "'latitude' must lie between -90 and 90 degrees, north positive");
  EXPECT_EQ(problem([](World& w) { w.start = "yesterday"; }),
            "'start' is no date: 'yesterday'; write for example 2026-06-21T06:00+02:00");
}

}  // namespace
}  // namespace espalier::turtle::world_test
