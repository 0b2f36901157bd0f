#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment {
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

}  // namespace
}  // namespace espalier::environment
