// The worked examples of recorded runs of the published program, and what follows from them.

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_clover_test {
namespace {

constexpr const char* kTwenty =
    R"({"compatible":true,"gridSize":[20,20],"range":[20,20],"position":[0,0],"transmittance":0.5)";

/// The cells of the raster of 20 x 20 that a leaf shades.
std::set<std::pair<int, int>> shadedBy(const core::Vec3& place, double area) {
  const auto process = openProcess("clover", std::string(kTwenty) + "}");
  answersOf(*process, QueryBuilder().add(place, {1, area}).batch());
  std::set<std::pair<int, int>> shaded;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      if (*answersOf(*process, QueryBuilder().add({x + 0.5, y + 0.5, 0}, {0}).batch())[0][0] < 1.0) {
        shaded.insert({x, y});
      }
    }
  }
  return shaded;
}

TEST(PublishedClover, ALeafHasItsOutermostCellsOnTheLowSidesOnly) {
  // radius √(12.6/π) = 2.003: half-axes of int(2.003 + 1) = 3 cells around the cell (10, 10)
  const auto shaded = shadedBy({10.5, 10.5, 0}, 12.6);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const int i = x - 10;
      const int j = y - 10;
      EXPECT_EQ(shaded.contains({x, y}), i >= -3 && i < 3 && j >= -3 && j < 3 && i * i + j * j <= 9) << x << " " << y;
    }
  }
  EXPECT_TRUE(shaded.contains({7, 10}) && shaded.contains({12, 10}) && !shaded.contains({13, 10}));
  EXPECT_TRUE(shaded.contains({10, 7}) && !shaded.contains({10, 13}));
}

TEST(PublishedClover, AThreeFourFiveEllipseHasItsBorder) {
  // radius 4.5: half-axes of 5 cells; (3/5)² + (4/5)² is exactly 1
  const auto shaded = shadedBy({10.5, 10.5, 0}, std::numbers::pi * 4.5 * 4.5);
  EXPECT_TRUE(shaded.contains({13, 14}));
  EXPECT_TRUE(shaded.contains({6, 7}));
  EXPECT_FALSE(shaded.contains({14, 14}));
}

TEST(PublishedClover, ALeafAcrossTheBorderIsCutAndATinyOneMarksNothing) {
  EXPECT_EQ(shadedBy({0.5, 0.5, 0}, 1e-6), (std::set<std::pair<int, int>>{{0, 0}}));
  EXPECT_EQ(shadedBy({10.5, 10.5, 0}, 1e-6), (std::set<std::pair<int, int>>{{10, 10}, {9, 10}, {10, 9}}));
  EXPECT_EQ(shadedBy({-0.5, 5.5, 0}, 12.6).size(), 5U + 5U);
  EXPECT_TRUE(shadedBy({10.5, 10.5, 0}, 0.9e-7).empty());
}

TEST(PublishedClover, CountsStayBetween0And255) {
  const auto process = openProcess("clover", std::string(kTwenty) + "}");
  const auto lightAfter = [&](const std::vector<double>& sent, int times) {
    QueryBuilder builder;
    for (int i = 0; i < times; ++i) {
      builder.add({5, 5, 0}, sent);
    }
    answersOf(*process, builder.batch());
    return *answersOf(*process, QueryBuilder().add({5, 5, 0}, {0}).batch())[0][0];
  };
  EXPECT_EQ(lightAfter({2, 3}, 1), 1.0);
  EXPECT_EQ(lightAfter({1, 3}, 1), 0.5);
  // 255 of 300 stay, so 254 removed leave one
  lightAfter({1, 3}, 300);
  EXPECT_EQ(lightAfter({2, 3}, 254), 0.5);
}

TEST(PublishedClover, ADarkLeafLetsATenThousandthPass) {
  const auto process = openProcess("clover", R"({"compatible":true,"transmittance":0})");
  const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0.1}).add({0, 0, 0}, {0}).batch());
  EXPECT_NEAR(*table[1][0], 0.0001, 1e-12);
}

TEST(PublishedClover, CellsShowThePixelOfTheirIndexTimesPixelsPerCell) {
  // 4 pixels on 10 cells: 0 0 0 1 1 1 2 2 2 3; row 0 of the cells is the lowest row of the map
  const auto process = openProcess(
      "clover",
      R"({"compatible":true,"gridSize":[10,1],"range":[10,1],"position":[0,0],"lightMap":[[9,9,9,9],[0,51,102,153]]})");
  const std::vector<int> expected{0, 0, 0, 1, 1, 1, 2, 2, 2, 3};
  for (int x = 0; x < 10; ++x) {
    const auto light = answersOf(*process, QueryBuilder().add({x + 0.5, 0.5, 0}, {0}).batch())[0][0];
    EXPECT_NEAR(*light, 0.2 * expected[static_cast<std::size_t>(x)], 1e-12) << x;
  }
}

}  // namespace
}  // namespace espalier::environment::published_clover_test
