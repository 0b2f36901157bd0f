#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::ornament_test {
namespace {

constexpr const char* kTen = R"({"range":[10,10],"position":[0,0],"gridSize":[100,100]})";

TEST(Ornament, CountsTheObjectsOverAPointItsOwnIncluded) {
  // discs of radius 1 in a row at distance 0.75: each middle lies under its own disc and its neighbours' only
  const auto process = openProcess("ornament", kTen);
  const auto table = answersOf(*process, QueryBuilder()
                                             .add({2, 2, 0}, {0, 1})
                                             .add({2.75, 2, 0}, {0, 1})
                                             .add({3.5, 2, 0}, {0, 1})
                                             .add({9, 9, 0}, {0, 1})
                                             .batch());
  EXPECT_EQ(firstValues(table), (std::vector<double>{2, 3, 2, 1}));
  EXPECT_EQ(table[0][1], 255.0);
}

TEST(Ornament, IsEmptyAgainInEveryStep) {
  const auto process = openProcess("ornament", kTen);
  for (int step = 0; step < 3; ++step) {
    EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({2, 2, 0}, {0, 1}).batch())), std::vector<double>{1});
  }
}

TEST(Ornament, OnlyQueriesWithTwoParametersTakePart) {
  const auto process = openProcess("ornament", kTen);
  const auto table = answersOf(*process, QueryBuilder().add({2, 2, 0}, {1}).add({2, 2, 0}, {0, 1}).batch());
  EXPECT_EQ(table[0][0], std::nullopt);
  EXPECT_EQ(table[1][0], 1.0);
}

TEST(Ornament, OutsideTheRasterEverythingIs0) {
  const auto process = openProcess("ornament", kTen);
  const auto table = answersOf(*process, QueryBuilder().add({-0.01, 2, 0}, {0, 1}).add({0.5, 2, 0}, {0, 0.1}).batch());
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{0.0, 0.0}));
  // the part of the object outside's that is inside counts
  EXPECT_EQ(table[1][0], 2.0);
}

TEST(Ornament, CountsTheObjectsWhoseDiscHoldsTheMiddleOfACell) {
  // cells of size 1; queries at middles ask, discs of all sizes lie inside, across the borders and outside
  const auto process = openProcess("ornament", R"({"range":[40,30],"position":[0,0],"gridSize":[40,30]})");
  std::mt19937_64 engine(17);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int round = 0; round < 20; ++round) {
    struct Placed {
      core::Vec3 middle;
      double radius;
    };
    std::vector<Placed> discs;
    QueryBuilder builder;
    for (int i = 0; i < 60; ++i) {
      const bool isAsking = i % 2 == 0;
      const core::Vec3 middle =
          isAsking ? core::Vec3{std::floor(share(engine) * 40.0) + 0.5, std::floor(share(engine) * 30.0) + 0.5, 0.0}
                   : core::Vec3{share(engine) * 60.0 - 10.0, share(engine) * 50.0 - 10.0, 0.0};
      discs.push_back({middle, isAsking ? 0.1 : share(engine) * (i % 7 == 0 ? 60.0 : 6.0)});
      builder.add(middle, {0.0, discs.back().radius});
    }
    const std::vector<double> counts = firstValues(answersOf(*process, builder.batch()));
    for (std::size_t asking = 0; asking < discs.size(); asking += 2) {
      const core::Vec3 place = discs[asking].middle;
      const auto covers = [&](const Placed& disc) { return core::length(disc.middle - place) <= disc.radius; };
      EXPECT_EQ(counts[asking], static_cast<double>(std::count_if(discs.begin(), discs.end(), covers)));
    }
  }
}

TEST(Ornament, ThePublishedOneCountsAtMost255Objects) {
  const auto process =
      openProcess("ornament", R"({"range":[10,10],"position":[0,0],"gridSize":[100,100],"compatible":true})");
  QueryBuilder builder;
  for (int i = 0; i < 300; ++i) {
    builder.add({2, 2, 0}, {0, 1});
  }
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), std::vector<double>(300, 255.0));
}

}  // namespace
}  // namespace espalier::environment::ornament_test
