// The worked examples of recorded runs of the published programs honda81, ecosystem and ornament, and what follows.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_variants_test {
namespace {

constexpr const char* kHonda = R"({"compatible":true,"radius":0.3})";

TEST(PublishedHonda, DistancesInFloatsDecideForDecimals) {
  // distances of 0.3 in decimals; in doubles none of these is within 0.3
  const auto process = openProcess("honda", kHonda);
  const auto blocked = [&](const core::Vec3& a, const core::Vec3& b) {
    const auto values = firstValues(answersOf(*process, QueryBuilder().add(a, {1}).add(b, {1}).batch()));
    EXPECT_EQ(values[0], values[1]);
    return values[0] == 0.0;
  };
  EXPECT_TRUE(blocked({0.1, 0, 0}, {0.4, 0, 0}));
  EXPECT_FALSE(blocked({10.2, 0, 0}, {10.5, 0, 0}));
  EXPECT_TRUE(blocked({20, 0, 20}, {20.3, 0, 20}));
  EXPECT_TRUE(blocked({0.1, 0, 30.2}, {0.1, 0, 30.5}));
}

TEST(PublishedHonda, EqualsAllPairsInFloatsOnDecimalLattices) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> lattice(-40, 40);
  std::uniform_int_distribution<int> few(1, 3);
  const auto process = openProcess("honda", kHonda);
  int ties = 0;
  for (int round = 0; round < 20; ++round) {
    QueryBuilder builder;
    std::vector<std::array<double, 4>> tips;
    for (int i = 0; i < 60; ++i) {
      tips.push_back({lattice(random) / 10.0, lattice(random) / 10.0, static_cast<double>(few(random)),
                      static_cast<double>(few(random) / 2)});
      builder.add({tips.back()[0], 7, tips.back()[1]}, {tips.back()[2], tips.back()[3]});
    }
    const auto values = firstValues(answersOf(*process, builder.batch()));
    for (std::size_t i = 0; i < tips.size(); ++i) {
      bool isBlocked = false;
      for (std::size_t j = 0; j < tips.size(); ++j) {
        const float dx = static_cast<float>(tips[j][0]) - static_cast<float>(tips[i][0]);
        const float dz = static_cast<float>(tips[j][1]) - static_cast<float>(tips[i][1]);
        const bool isNear = dx * dx + dz * dz <= 0.3F * 0.3F;
        ties += i != j && std::abs(std::hypot(dx, dz) - 0.3F) < 1e-5F ? 1 : 0;
        isBlocked = isBlocked || (i != j && tips[i][3] == tips[j][3] && tips[i][2] <= tips[j][2] && isNear);
      }
      ASSERT_EQ(values[i], isBlocked ? 0.0 : 1.0) << round << " " << i;
    }
  }
  EXPECT_GT(ties, 50);
}

TEST(PublishedEcosystem, RadiiThatTouchInDecimalsOverlapAsFloatsSay) {
  // radii of 0.1 and 0.2 at a distance of 0.3
  const auto process = openProcess("ecosystem", R"({"compatible":true})");
  const auto isFree = [&](const core::Vec3& a, const core::Vec3& b) {
    return firstValues(answersOf(*process, QueryBuilder().add(a, {0.1}).add(b, {0.2}).batch()))[0] == 1.0;
  };
  EXPECT_FALSE(isFree({0.1, 0, 0}, {0.4, 0, 0}));
  EXPECT_TRUE(isFree({10.2, 0, 0}, {10.5, 0, 0}));
  EXPECT_FALSE(isFree({20, 0, 20}, {20.3, 0, 20}));
}

TEST(PublishedEcosystem, WithVigorTheStringOrderDecides) {
  // 1 dominates 2, 2 dominates 3, and 3 is far from 1. In string order 3, 2, 1 all of 3 and 2 are dominated.
  const auto process = openProcess("ecosystem", R"({"compatible":true,"vigor":true})");
  QueryBuilder builder;
  builder.add({4, 0, 0}, {1.5, 1}).add({2, 0, 0}, {1.5, 2}).add({0, 0, 0}, {1.5, 3});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{0, 0, 1}));
  const auto own = openProcess("ecosystem", R"({"vigor":true})");
  EXPECT_EQ(firstValues(answersOf(*own, builder.batch())), (std::vector<double>{1, 0, 1}));
}

TEST(PublishedOrnament, RadiusZeroStampsThreeCells) {
  // a = b = 1: the own cell, the one to the left and the one below
  const auto process =
      openProcess("ornament", R"({"compatible":true,"range":[10,10],"position":[0,0],"gridSize":[10,10]})");
  QueryBuilder builder;
  builder.add({5.5, 5.5, 0}, {0, 0});
  for (const auto& [x, y] : {std::pair{4.5, 5.5}, {6.5, 5.5}, {5.5, 4.5}, {5.5, 6.5}, {4.5, 4.5}}) {
    builder.add({x, y, 0}, {0, -1.0});
  }
  const auto values = firstValues(answersOf(*process, builder.batch()));
  EXPECT_EQ(values, (std::vector<double>{1, 1, 0, 1, 0, 0}));
}

TEST(PublishedOrnament, CountsAtMost255AndOnlyTwoParameters) {
  const auto process =
      openProcess("ornament", R"({"compatible":true,"range":[10,10],"position":[0,0],"gridSize":[10,10]})");
  QueryBuilder builder;
  for (int i = 0; i < 300; ++i) {
    builder.add({5.5, 5.5, 0}, {0, 0});
  }
  builder.add({5.5, 5.5, 0}, {0, 0, 0});
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(table[0][0], 255.0);
  EXPECT_EQ(table[300][0], std::nullopt);
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({5.5, 5.5, 0}, {0, 0}).batch()))[0], 1.0);
}

}  // namespace
}  // namespace espalier::environment::published_variants_test
