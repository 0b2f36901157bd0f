#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/environment/query_builder.h"

namespace espalier::environment::crowding_test {
namespace {

using std::numbers::pi;

/// The part of a unit disc that another one at a distance d covers: the lens 2 acos(d/2) − d/2 √(4 − d²), over π.
double lens(double d) {
  return (2 * std::acos(d / 2) - d / 2 * std::sqrt(4 - d * d)) / pi;
}

TEST(Crowding, TwoEqualZonesShareTheirLens) {
  // sample points resolve the area to about 1/√samples of it; here to half a percent
  const auto process = openProcess("crowding", R"({"samples":4000})");
  for (const double d : {0.5, 1.0, 1.7, 2.1}) {
    const auto table = answersOf(*process, QueryBuilder().add({0, 3, 0}, {1, 0, 1}).add({0, -2, d}, {1, 0, 1}).batch());
    const double expected = d < 2 ? 1 - lens(d) / 2 : 1.0;
    EXPECT_NEAR(*table[0][1], expected, 0.005) << d;
    EXPECT_NEAR(*table[1][1], expected, 0.005) << d;
  }
}

TEST(Crowding, AsymmetryFavoursTheStrong) {
  // in the lens the shares are s^a/Σ s^a: 3/4 and 1/4 with strengths 3 and 1 and a = 1
  const auto shares = [](const std::string& configuration) {
    const auto process = openProcess("crowding", configuration);
    const auto table = answersOf(*process, QueryBuilder().add({0, 0, 0}, {1, 0, 3}).add({1, 0, 0}, {1, 0, 1}).batch());
    return std::pair(*table[0][1], *table[1][1]);
  };
  const auto check = [](const std::pair<double, double>& found, double strong, double weak) {
    EXPECT_NEAR(found.first, 1 - lens(1) * (1 - strong), 0.005);
    EXPECT_NEAR(found.second, 1 - lens(1) * (1 - weak), 0.005);
  };
  check(shares(R"({"samples":4000})"), 0.75, 0.25);
  check(shares(R"({"samples":4000,"asymmetry":0})"), 0.5, 0.5);
  check(shares(R"({"samples":4000,"asymmetry":2})"), 0.9, 0.1);
  check(shares(R"({"samples":4000,"competition":"largest"})"), 1, 0);
}

TEST(Crowding, APlantWithLessThanItsLeastShareDies) {
  const auto process = openProcess("crowding", R"({"competition":"largest","leastShare":0.25})");
  // the small one lies within the large one; a shade plant is content with nothing
  const auto table = answersOf(
      *process,
      QueryBuilder().add({0, 0, 0}, {2}).add({0.5, 0, 0}, {1}).add({0, 0, 0.5}, {1, 0}).add({5, 0, 0}, {1, 1}).batch());
  EXPECT_EQ(firstValues(table), (std::vector<double>{1, 0, 1, 1}));
  EXPECT_EQ(table[2][1], 0.0);
  EXPECT_EQ(table[3][1], 1.0);
}

TEST(Crowding, DeathComesWithItsProbability) {
  // 2000 plants under large ones; each dies with probability 0.3. Binomial: 5 standard deviations are 0.051, exceeded
  // by chance with a probability below 10⁻⁶; the seed is fixed
  const auto process = openProcess("crowding", R"({"competition":"largest","deathProbability":0.3,"samples":4})");
  QueryBuilder builder;
  builder.add({0, 0, 0}, {9});
  for (int i = 0; i < 2000; ++i) {
    builder.add({0.001 * i, 0, 0}, {1});
  }
  double living = -1;
  for (const double value : firstValues(answersOf(*process, builder.batch()))) {
    living += value;
  }
  EXPECT_NEAR(living / 2000, 0.7, 0.051);
}

TEST(Crowding, APeriodicPlotHasNoBorders) {
  const auto process = openProcess("crowding", R"({"extent":[0,10,0,10],"periodic":true,"samples":4000})");
  // one unit apart across the border, and far outside of the plot
  const auto table = answersOf(
      *process,
      QueryBuilder().add({0.5, 0, 5}, {1, 0, 1}).add({9.5, 0, 5}, {1, 0, 1}).add({45.5, 0, -13}, {1, 0, 1}).batch());
  EXPECT_NEAR(*table[0][1], 1 - lens(1) / 2, 0.005);
  EXPECT_NEAR(*table[1][1], 1 - lens(1) / 2, 0.005);
  EXPECT_EQ(table[2][1], 1.0);
  // a zone as wide as the plot meets itself
  EXPECT_LT(*answersOf(*process, QueryBuilder().add({1, 0, 1}, {8, 0, 1}).batch())[0][1], 0.7);
}

TEST(Crowding, AStandThatIsTurnedByARightAngleKeepsItsShares) {
  // plants at places that a quarter about the middle of the plot takes to places in it; the points of a zone do not
  // turn with them, so shares agree as far as points resolve a zone
  QueryBuilder plain;
  QueryBuilder turned;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 + 9.0 * std::fmod(0.7548776662466927 * i, 1.0);
    const double z = 0.5 + 9.0 * std::fmod(0.5698402909980532 * i, 1.0);
    const double radius = 0.6 + 0.02 * (i % 20);
    plain.add({x, 0, z}, {radius, 0, radius});
    turned.add({z, 0, 10 - x}, {radius, 0, radius});
  }
  const std::string keys = R"({"samples":4000,"periodic":true,"extent":[0,10,0,10]})";
  const auto before = answersOf(*openProcess("crowding", keys), plain.batch());
  const auto after = answersOf(*openProcess("crowding", keys), turned.batch());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(*before[i][1], *after[i][1], 0.01) << i;
  }
}

TEST(Crowding, SeedsFlyAsFarAsTheyShouldAndGerminateByTheSite) {
  // 5000 seeds with the mean distance 3: the standard deviation of a flight is 3/√2, that of the mean 0.03. Half of the
  // plot has quality 0.5, the other 0; from the middle half of them fall on each. 5 standard deviations, fixed seed
  const auto process =
      openProcess("crowding", R"({"extent":[-100,100,-100,100],"siteQuality":[[0.5],[0]],"germination":0.8})");
  QueryBuilder builder;
  for (int i = 0; i < 5000; ++i) {
    builder.add({0, 1.5, 0}, {0, 3, 0, 0, 0});
  }
  double distance = 0;
  double germinated = 0;
  double onGoodSide = 0;
  for (const auto& row : answersOf(*process, builder.batch())) {
    EXPECT_EQ(row[2], 1.5);
    distance += std::hypot(*row[1], *row[3]) / 5000;
    onGoodSide += *row[3] < 0 ? 1 : 0;
    germinated += *row[0];
    EXPECT_EQ(row[4], *row[3] < 0 ? 0.5 : 0.0);
    EXPECT_LE(*row[0], *row[4] * 2);
  }
  EXPECT_NEAR(distance, 3, 0.15);
  EXPECT_NEAR(onGoodSide / 5000, 0.5, 0.036);
  EXPECT_NEAR(germinated / onGoodSide, 0.4, 0.05);
}

TEST(Crowding, SeedsDoNotGerminateUnderPlants) {
  const auto process = openProcess("crowding", "");
  const auto table = answersOf(
      *process, QueryBuilder().add({0, 0, 0}, {1}).add({0.5, 0, 0}, {0, 0, 0, 0}).add({2, 0, 0}, {0, 0, 0, 0}).batch());
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{0.0, 0.5, 0.0, 0.0}));
  EXPECT_EQ(table[2], (std::vector<std::optional<double>>{1.0, 2.0, 0.0, 0.0}));
}

TEST(Crowding, BeyondThePlotNothingThrives) {
  const auto process = openProcess("crowding", R"({"extent":[0,4,0,2],"siteQuality":[[0.1,0.2],[0.3,0.4]]})");
  const auto table = answersOf(*process, QueryBuilder()
                                             .add({1, 0, 0.5}, {0.1, 0, 1})
                                             .add({3, 0, 0.5}, {0.1, 0, 1})
                                             .add({3, 0, 1.5}, {0.1, 0, 1})
                                             .add({5, 0, 1.5}, {0.1, 0, 1})
                                             .batch());
  EXPECT_EQ(table[0][2], 0.1);
  EXPECT_EQ(table[1][2], 0.2);
  EXPECT_EQ(table[2][2], 0.4);
  EXPECT_EQ(table[3][2], 0.0);
}

TEST(Crowding, WhatCannotBeIsAnError) {
  turtle::EnvironmentContext context;
  context.world.up = {1, 0, 2};
  auto made = makeProcess("crowding", "");
  EXPECT_EQ(made.value()->open(context)->message,
            "Environment 'crowding' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
  EXPECT_EQ(
      errorsOf(makeProcess("crowding", R"({"extent":[1,0,0,1]})")),
      "error: environment process 'crowding': 'extent' is not a smallest and a largest number for each of the two "
      "horizontal coordinates\n"
      "   hint: write for example \"extent\": [-5, 5, -5, 5]");
  EXPECT_EQ(errorsOf(makeProcess("crowding", R"({"periodic":true})")),
            "error: environment process 'crowding': 'periodic' and 'siteQuality' need the 'extent' of the plot\n"
            "   hint: write for example \"extent\": [-5, 5, -5, 5]");
}

}  // namespace
}  // namespace espalier::environment::crowding_test
