#include <gtest/gtest.h>

#include <cmath>

#include "tests/environment/query_builder.h"

namespace espalier::environment::attractors_test {
namespace {

std::vector<std::optional<double>> pullAt(const std::string& configuration, const core::Vec3& place) {
  const auto process = openProcess("attractors", configuration);
  return answersOf(*process, QueryBuilder().add(place, {0, 0, 0, 0}).batch())[0];
}

TEST(Attractors, PullByThePowerOfTheirDistance) {
  // strength 50 at distance 5 along (3, 4, 0): 50/25 of the unit vector
  const auto row = pullAt(R"({"points":[[3,4,0,50]]})", {});
  EXPECT_DOUBLE_EQ(*row[0], 2.0 * 0.6);
  EXPECT_DOUBLE_EQ(*row[1], 2.0 * 0.8);
  EXPECT_EQ(*row[2], 0.0);
  EXPECT_DOUBLE_EQ(*row[3], 5.0);
  EXPECT_DOUBLE_EQ(*pullAt(R"({"points":[[3,4,0,50]],"exponent":0})", {})[0], 30.0);
}

TEST(Attractors, AddUpAndPushWhenNegative) {
  const auto row = pullAt(R"({"points":[[2,0,0,8],[-1,0,0,-1],[0,0,10,0]]})", {});
  EXPECT_DOUBLE_EQ(*row[0], 8.0 / 4.0 + 1.0);
  EXPECT_DOUBLE_EQ(*row[3], 1.0);
}

TEST(Attractors, DoNotActBeyondTheirReachNorStrongerThanAtTheNearest) {
  EXPECT_EQ(*pullAt(R"({"points":[[5,0,0,1]],"reach":4.99})", {})[0], 0.0);
  EXPECT_DOUBLE_EQ(*pullAt(R"({"points":[[0.001,0,0,1]],"nearest":0.5})", {})[0], 4.0);
  EXPECT_EQ(*pullAt(R"({"points":[[0,0,0,1]]})", {})[0], 0.0);
}

TEST(Attractors, WithoutAnyNobodyIsLeftToThinkThatNothingPulls) {
  const auto process = openProcess("attractors", "");
  QueryBuilder builder;
  builder.add({1, 2, 3}, {0, 0, 0});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const auto error = process->step(builder.batch(), replies);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "Environment 'attractors' has no attractors, so nothing would pull. Give 'points': [[x, y, z, strength]].");
}

}  // namespace
}  // namespace espalier::environment::attractors_test
