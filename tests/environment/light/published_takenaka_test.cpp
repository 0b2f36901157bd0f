// The worked example of recorded runs of the published program, and what follows from it.

#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_takenaka_test {
namespace {

std::vector<double> productsOf(const std::vector<core::Vec3>& places, const std::string& more = "") {
  const auto process = openProcess("takenaka", R"({"compatible":true)" + more + "}");
  QueryBuilder builder;
  for (const core::Vec3& place : places) {
    builder.add(place, {4, 0});
  }
  std::vector<double> products;
  for (const auto& row : answersOf(*process, builder.batch())) {
    products.push_back(row[1].value_or(999.0));
  }
  return products;
}

// e · LA/4 · s² · a · 8.64 with e = 0.015, LA = 4, s = 1.5 and a = 1 − 0.6²; a ball lets 0.36 pass
constexpr double kFull = 0.186624;

void expectNear(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-6) << i;
  }
}

TEST(PublishedTakenaka, WithoutASourceLightComesFromFarAlongX) {
  expectNear(productsOf({{1, 1, 1}, {1, 3, 1}, {1, 1, 9}, {7, 1, 9}}), {kFull, kFull, 0.0671846, kFull});
}

TEST(PublishedTakenaka, QueriesNeedTwoParametersOrMore) {
  const auto process = openProcess("takenaka", R"({"compatible":true})");
  const auto table = answersOf(
      *process, QueryBuilder().add({0, 0, 0}, {4, 0.01, 7, 8}).add({9, 0, 0}, {4}).add({0, 9, 0}, {4, 0}).batch());
  EXPECT_EQ(table[0][0], 4.0);
  EXPECT_NEAR(*table[0][1], kFull - 0.01, 1e-6);
  EXPECT_EQ(table[0][2], std::nullopt);
  EXPECT_EQ(table[1][0], std::nullopt);
}

TEST(PublishedTakenaka, BallsBeyondASourceCount) {
  // the source is between the two, so each is ahead of the other
  expectNear(productsOf({{0, 0, 0}, {0, 50, 0}}, R"(,"sources":[[0,20,0,5]])"), {kFull * 0.36, kFull * 0.36});
}

TEST(PublishedTakenaka, ADiskReplacesAllSources) {
  // height 10, radius 5 around the axis: too high, too far aside, lit, and shaded by the third
  expectNear(productsOf({{0, 10.5, 0}, {4, 1, 4}, {3, 8, 3}, {3, 1, 3}}, R"(,"diskSource":[5,0,10,0])"),
             {0, 0, kFull, kFull * 0.36});
}

}  // namespace
}  // namespace espalier::environment::published_takenaka_test
