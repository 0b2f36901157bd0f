// The worked examples of recorded runs of the published program, and what follows from them.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_shadow_test {
namespace {

constexpr const char* kSmall = R"({"compatible":true,"gridSize":21,"gridSpan":10,"shadowDepth":3,"sampleRadius":1)";

void expectNear(const std::vector<std::optional<double>>& row, const std::vector<double>& expected) {
  ASSERT_GE(row.size(), expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(row[k].value_or(999.0), expected[k], 5e-7) << k;
  }
}

TEST(PublishedShadow, OneCasterAndTheLightAroundIt) {
  const auto process = openProcess("shadow", std::string(kSmall) + "}");
  const auto table = answersOf(*process, QueryBuilder()
                                             .add({0.4, 3.9, 0}, {1, 0, 0, 0})
                                             .add({0, 3.2, 0}, {0, 0, 0, 0})
                                             .add({1.1, 2.5, 0}, {0, 0, 0})
                                             .batch());
  expectNear(table[0], {0.9652, 0.0232, 0.319754, 0});
  expectNear(table[1], {0.536, 0, 0.183246, 0});
  expectNear(table[2], {0.983005});
  // the gradient needs four parameters
  EXPECT_EQ(table[2][1], std::nullopt);
}

TEST(PublishedShadow, TheBiasIsInTheField) {
  const auto process = openProcess("shadow", std::string(kSmall) + R"(,"lightVerticalBias":0.5})");
  const auto table = answersOf(
      *process, QueryBuilder().add({0, 4, 0}, {0, 0, 0, 0}).add({0, 25, 0}, {0}).add({3, -2, 0}, {0}).batch());
  expectNear(table[0], {0.595238, 0, 0.047619, 0});
  // above the grid that of the corner N − 2, below it that of the lowest voxel
  expectNear(table[1], {0.952381});
  expectNear(table[2], {1});
}

TEST(PublishedShadow, OutsideTheGridTheCasterAndTheLightAreThoseOfTheBorder) {
  // far outside along x: the voxel 0 on one side, and the corner N − 2 = 19 on the other
  const auto process = openProcess("shadow", std::string(kSmall) + "}");
  const auto table = answersOf(*process, QueryBuilder()
                                             .add({-99, 3, 0}, {1})
                                             .add({-99, 3, 0}, {0})
                                             .add({-10, 3, 0}, {0})
                                             .add({9, 3, 0}, {1})
                                             .add({99, 3, 0}, {0})
                                             .batch());
  expectNear(table[0], {0.42});
  expectNear(table[1], {0.42});
  expectNear(table[2], {0.42});
  expectNear(table[3], {0.42});
  expectNear(table[4], {0.42});
}

TEST(PublishedShadow, AWeightAbove1MakesNearVoxelsDark) {
  // C1 · C2^−d is 6.9 · 6.9^−1 = 1 one voxel below, 6.9^(1−√2) diagonally: 1 − 0.449…
  const auto process =
      openProcess("shadow", R"({"compatible":true,"gridSize":21,"gridSpan":10,"shadowWeight":6.9,"shadowDepth":2})");
  const auto table = answersOf(
      *process, QueryBuilder().add({0, 5, 0}, {1}).add({0, 4, 0}, {0}).add({1, 4, 0}, {0}).add({0, 3, 0}, {0}).batch());
  expectNear(table[0], {0});
  expectNear(table[1], {0});
  expectNear(table[2], {1.0 - std::pow(6.9, 1.0 - std::sqrt(2.0))});
  expectNear(table[3], {1});
}

TEST(PublishedShadow, AnEvenGridReadsHalfAVoxelAside) {
  // N = 4, S = 1.5: w = 1. The caster at 0.2 casts from trunc(0.2 + 2) = 2. Light at 0.2: corner trunc(0.2 + 1.5) = 1,
  // part 0.2, so 1 − 0.2 · C1; at 0.5 the corner is 2 and the part 0.5
  const auto process = openProcess("shadow", R"({"compatible":true,"gridSize":4,"gridSpan":1.5,"shadowDepth":1})");
  const auto table = answersOf(*process, QueryBuilder().add({0.2, 1, 0}, {1}).add({0.5, 1, 0}, {0}).batch());
  // along z the place 0 has the corner 1 and the part 0, so the voxel z = 2 of the caster is not seen at all
  expectNear(table[0], {1});
  expectNear(table[1], {1});
}

TEST(PublishedShadow, TheFirstRandomNumbersAreThoseOfTheSelectionGenerator) {
  // voxels of z = x = 0, y = 1 … 4 at the beginning: 1 − R + R·u with u = 4e-14, 0.000985, 0.0416, 0.1766
  const auto process = openProcess("shadow", R"({"compatible":true,"gridSize":11,"gridSpan":5,"lightRandomness":0.5})");
  QueryBuilder builder;
  for (int y = 0; y < 5; ++y) {
    builder.add({-5, static_cast<double>(y), -5}, {0});
  }
  const auto light = firstValues(answersOf(*process, builder.batch()));
  EXPECT_EQ(light[0], 1.0);
  EXPECT_NEAR(light[1], 0.5, 1e-7);
  EXPECT_NEAR(light[2], 0.5 + 0.5 * 0.000985, 1e-6);
  EXPECT_NEAR(light[3], 0.5 + 0.5 * 0.0416, 3e-5);
  EXPECT_NEAR(light[4], 0.5 + 0.5 * 0.1766, 3e-5);
  // the sequence goes on with the next pass, also from a saved state
  const std::string state = process->save();
  const auto second = firstValues(answersOf(*process, builder.batch()));
  EXPECT_NE(second[2], light[2]);
  const auto other = openProcess("shadow", R"({"compatible":true,"gridSize":11,"gridSpan":5,"lightRandomness":0.5})");
  ASSERT_FALSE(other->restore(state));
  EXPECT_EQ(firstValues(answersOf(*other, builder.batch())), second);
}

}  // namespace
}  // namespace espalier::environment::published_shadow_test
