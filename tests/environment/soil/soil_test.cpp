#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "environment/soil/soil_field.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::soil_test {
namespace {

std::vector<double> valuesOf(const std::vector<std::optional<double>>& row) {
  std::vector<double> values;
  for (const auto& value : row) {
    values.push_back(value.value_or(999.0));
  }
  return values;
}

double sumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

TEST(SoilField, DiffusionFromAPointSpreadsAsTheSumOfIndependentSteps) {
  // Face fluxes move relaxation/4 of a cell to each of its four neighbours in a step: a random walk whose steps have
  // the variance 2 · relaxation/4 along x. After k steps from one cell, far from borders, the mean is that cell and the
  // variance along each axis k · relaxation/2 cells².
  const std::size_t side = 81;
  SoilField field({{0, 0, 0}, {81, 81, 1}, {side, side, 1}}, std::vector<double>(side * side, 0.0), {}, {});
  field.cells()[40 * side + 40] = 1.0;
  field.spread({.stepCount = 30, .relaxation = 0.6});
  double total = 0.0;
  double mean = 0.0;
  double variance = 0.0;
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t x = 0; x < side; ++x) {
      const double c = field.cells()[y * side + x];
      const double dx = static_cast<double>(x) - 40.0;
      total += c;
      mean += c * dx;
      variance += c * dx * dx;
    }
  }
  EXPECT_NEAR(total, 1.0, 1e-12);
  EXPECT_NEAR(mean, 0.0, 1e-12);
  EXPECT_NEAR(variance, 30 * 0.6 / 2.0, 1e-10);
}

TEST(SoilField, MatterIsConservedAroundObstaclesInThePlaneAndInSpace) {
  for (const std::size_t depth : {std::size_t{1}, std::size_t{7}}) {
    const std::size_t count = 20 * 15 * depth;
    std::vector<double> initial(count);
    std::vector<std::uint8_t> isObstacle(count);
    for (std::size_t i = 0; i < count; ++i) {
      isObstacle[i] = i % 7 == 3 ? 1 : 0;
      initial[i] = isObstacle[i] != 0 ? 0.0 : static_cast<double>(i * 7919 % 101);
    }
    SoilField field({{0, 0, 0}, {2, 1, 1}, {20, 15, depth}}, initial, isObstacle, {});
    field.spread({.stepCount = 500, .relaxation = 0.9});
    EXPECT_NEAR(sumOf(field.cells()) / sumOf(initial), 1.0, 1e-12);
    // nothing enters an obstacle
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_TRUE(isObstacle[i] == 0 || field.cells()[i] == 0.0);
    }
  }
}

TEST(SoilField, WithoutObstaclesTheFastRowsGiveTheSameBitsAsTheCarefulOnes) {
  for (const std::size_t depth : {std::size_t{1}, std::size_t{5}}) {
    std::vector<double> initial(9 * 8 * depth);
    for (std::size_t i = 0; i < initial.size(); ++i) {
      initial[i] = std::sin(static_cast<double>(i));
    }
    const SoilField::Shape shape{{0, 0, 0}, {1, 1, 1}, {9, 8, depth}};
    SoilField fast(shape, initial, {}, {});
    // a map without obstacles switches the fast rows off
    SoilField careful(shape, initial, std::vector<std::uint8_t>(initial.size(), 0), {});
    fast.spread({.stepCount = 5, .relaxation = 0.7});
    careful.spread({.stepCount = 5, .relaxation = 0.7});
    EXPECT_EQ(fast.cells(), careful.cells());
  }
}

TEST(SoilField, SpreadingStopsBelowTheTolerance) {
  // every step halves the difference of two cells' distance to their mean by (1 - 2 · 0.5/4) = 0.75
  SoilField field({{0, 0, 0}, {1, 1, 1}, {2, 1, 1}}, {1, 0}, {}, {});
  field.spread({.stepCount = 1000, .tolerance = 0.1});
  // changes 0.125, 0.09375: stops after the second
  EXPECT_DOUBLE_EQ(field.cells()[0], 1.0 - 0.125 - 0.09375);
}

TEST(SoilField, SourcesKeepTheirConcentration) {
  SoilField field({{0, 0, 0}, {1, 1, 1}, {3, 1, 1}}, {1, 0, 0}, {}, {1, 0, 0});
  for (int step = 0; step < 2000; ++step) {
    field.spread({.stepCount = 1, .relaxation = 1.0});
  }
  EXPECT_NEAR(field.cells()[2], 1.0, 1e-6);
}

TEST(SoilField, LinesAreBlockedByObstaclesTheyCross) {
  // cells of 1, an obstacle at (2, 1)
  std::vector<std::uint8_t> isObstacle(16, 0);
  isObstacle[1 * 4 + 2] = 1;
  const SoilField field({{0, 0, 0}, {4, 4, 1}, {4, 4, 1}}, std::vector<double>(16, 0.0), isObstacle, {});
  EXPECT_TRUE(field.isBlocked({0.5, 1.5, 0}, {3.5, 1.5, 0}));
  EXPECT_TRUE(field.isBlocked({3.5, 1.5, 0}, {0.5, 1.5, 0}));
  EXPECT_TRUE(field.isBlocked({2.5, 1.5, 0}, {2.5, 1.5, 0}));
  EXPECT_TRUE(field.isBlocked({1.5, 2.6, 0}, {3.5, 0.6, 0}));
  EXPECT_FALSE(field.isBlocked({0.5, 1.5, 0}, {1.9, 1.5, 0}));
  EXPECT_FALSE(field.isBlocked({0.5, 2.5, 0}, {3.5, 2.1, 0}));
  EXPECT_FALSE(field.isBlocked({-5, 9, 0}, {9, 9, 0}));
}

constexpr const char* kRow = R"({"domainSize":[4,1,1],"concentration":[[1,0.5,0,0]],"depletion":true)";

TEST(Soil, AQueryObtainsWhatThereIs) {
  const auto process = openProcess("soil", std::string(kRow) + "}");
  const auto table =
      answersOf(*process, QueryBuilder().add({0.5, 0, 0}, {0.25}).add({1.5, 0, 0}, {2}).add({9, 0, 0}, {2}).batch());
  EXPECT_EQ(firstValues(table), (std::vector<double>{0.25, 0.5, 0.0}));
  // the obtained amount is gone
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({0.5, 0, 0}, {9}).add({1.5, 0, 0}, {2}).batch())),
            (std::vector<double>{0.75, 0.0}));
}

TEST(Soil, ContendersGetTheSameShareOfWhatTheyWant) {
  // 1 is wanted 0.5 + 1.5 + 2 = 4 times over: a quarter each
  const auto process = openProcess("soil", std::string(kRow) + "}");
  const auto table =
      answersOf(*process, QueryBuilder().add({0.5, 0, 0}, {0.5}).add({0.1, 0, 0}, {1.5}).add({0.9, 0, 0}, {2}).batch());
  EXPECT_EQ(firstValues(table), (std::vector<double>{0.125, 0.375, 0.5}));
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({0.5, 0, 0}, {1}).batch())), std::vector<double>{0.0});
}

TEST(Soil, WhatIsGivenOffIsThereInTheNextStep) {
  const auto process = openProcess("soil", std::string(kRow) + "}");
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({2.5, 0, 0}, {-2}).add({2.6, 0, 0}, {1}).batch())),
            (std::vector<double>{-2.0, 0.0}));
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({2.5, 0, 0}, {5}).batch())), std::vector<double>{2.0});
}

TEST(Soil, WithoutDepletionNothingIsTaken) {
  const auto process = openProcess("soil", R"({"domainSize":[4,1,1],"concentration":[[1,0.5,0,0]]})");
  for (int step = 0; step < 2; ++step) {
    EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({0.5, 0, 0}, {0.4}).add({1.5, 0, 0}, {2}).batch())),
              (std::vector<double>{0.4, 0.5}));
  }
}

TEST(Soil, TheGradientIsPerLengthAndRelativeToTheRange) {
  // concentrations rise by 2 a cell of 0.5 along x and by 10 a cell of 1 along y; the range is 0 to 20
  const auto process = openProcess("soil", R"({"domainSize":[1.5,3,1],"concentrationRange":[0,20],)"
                                           R"("concentration":[[20,22,24],[10,12,14],[0,2,4]]})");
  const auto row = valuesOf(answersOf(*process, QueryBuilder().add({0.7, 1.5, 0}, {0, 0, 1, 0}).batch())[0]);
  EXPECT_EQ(row, (std::vector<double>{0, 2.0 / 0.5 / 20, 10.0 / 20, 0}));
  // at the border the missing neighbour counts as equal: half the difference
  const auto border = valuesOf(answersOf(*process, QueryBuilder().add({0.1, 1.5, 0}, {0, 0, 1, 0}).batch())[0]);
  EXPECT_DOUBLE_EQ(border[1], 0.5 * 2.0 / 0.5 / 20);
}

TEST(Soil, GravityDrawsDownAtTheAngleOfTheLayer) {
  // layers of 1 (30°) and 2 (60°) from the top at 3; the heading leans to +x
  const auto process = openProcess(
      "soil", R"({"domainSize":[3,3,1],"gridSize":[3,3,1],"layerThicknesses":[1,1],"geotropicAngles":[30,60]})");
  const auto directionAt = [&](double y, const core::Vec3& heading) {
    QueryBuilder builder;
    builder.add({1.5, y, 0}, {0, 2, 0, 0});
    builder.batch().heading[0] = heading;
    return valuesOf(answersOf(*process, builder.batch())[0]);
  };
  const double half = 2.0 * 0.5;
  const double most = 2.0 * std::sqrt(0.75);
  const auto isNear = [](const std::vector<double>& row, double x, double y) {
    return std::abs(row[1] - x) < 1e-12 && std::abs(row[2] - y) < 1e-12 && row[3] == 0.0;
  };
  EXPECT_TRUE(isNear(directionAt(2.5, {0.6, -0.8, 0}), half, -most));
  EXPECT_TRUE(isNear(directionAt(2.5, {-1, 0, 0}), -half, -most));
  EXPECT_TRUE(isNear(directionAt(1.5, {0.6, 0.8, 0}), most, -half));
  // below the last layer its angle goes on; a vertical heading has no side
  EXPECT_TRUE(isNear(directionAt(0.2, {0.6, 0.8, 0}), most, -half));
  EXPECT_TRUE(isNear(directionAt(2.5, {0, -1, 0}), 0, -2));
}

TEST(Soil, LayersAndRowsCountDownAlongTheWorldsUp) {
  // two layers of 2 in a box of 4, wet above and dry below
  turtle::EnvironmentContext context;
  const auto answerAt = [&](const core::Vec3& place, const core::Vec3& heading) {
    const auto process = openProcess("soil",
                                     R"({"domainSize":[4,4,4],"concentration":[[5],[1]],"layerThicknesses":[2,2],)"
                                     R"("geotropicAngles":[0,60]})",
                                     context);
    QueryBuilder builder;
    builder.add(place, {9, 2, 0, 0});
    builder.batch().heading[0] = heading;
    return valuesOf(answersOf(*process, builder.batch())[0]);
  };
  const double most = 2.0 * std::sqrt(0.75);
  for (const double sign : {1.0, -1.0}) {
    context.world.up = {0, 0, sign};
    const double high = sign > 0.0 ? 3.5 : 0.5;
    EXPECT_EQ(answerAt({0.5, 0.5, high}, {1, 0, 0}), (std::vector<double>{5, 0, 0, -2 * sign}));
    const auto below = answerAt({0.5, 3.5, 4.0 - high}, {1, 0, 0});
    EXPECT_EQ(below[0], 1.0);
    EXPECT_NEAR(below[1], most, 1e-12);
    EXPECT_EQ(below[2], 0.0);
    EXPECT_NEAR(below[3], -sign, 1e-12);
    context.world.up = {sign, 0, 0};
    EXPECT_EQ(answerAt({high, 0.5, 0.5}, {0, 1, 0}), (std::vector<double>{5, -2 * sign, 0, 0}));
    EXPECT_EQ(answerAt({4.0 - high, 0.5, 3.5}, {0, 1, 0})[0], 1.0);
  }
  context.world.up = {0, -1, 0};
  EXPECT_EQ(answerAt({0.5, 0.5, 0.5}, {1, 0, 0}), (std::vector<double>{5, 0, 2, 0}));
}

TEST(Soil, SlicesLieAcrossTheRowsAndUp) {
  // z is up: numbers run along x, rows down along z, slices along y
  turtle::EnvironmentContext context;
  context.world.up = {0, 0, 1};
  const auto process = openProcess(
      "soil", R"({"domainSize":[2,2,3],"sliceCount":2,"concentration":[[1,2],[3,4],[5,6],[11,12],[13,14],[15,16]]})",
      context);
  QueryBuilder builder;
  for (const core::Vec3 place : {core::Vec3{0.5, 0.5, 2.5}, {1.5, 0.5, 1.5}, {0.5, 1.5, 0.5}, {1.5, 1.5, 2.5}}) {
    builder.add(place, {99});
  }
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{1, 4, 15, 12}));
  context.world.up = {1, 1, 0};
  const auto error = process->open(context);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message, "Environment 'soil' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
}

TEST(Soil, RootsTurnAsideBeforeAStone) {
  // a stone of one cell straight below: passing its corner (2, 1) from (2.5, 2) needs atan(0.5/1) = 26.57°, so 28°,
  // to the first side tried, counter-clockwise
  const auto process = openProcess(
      "soil", R"({"domainSize":[5,3,1],"gridSize":[5,3,1],"obstacleMap":[[0,0,0,0,0],[0,0,0,0,0],[0,0,1,0,0]]})");
  QueryBuilder builder;
  builder.add({2.5, 2.0, 0}, {0, 0, 0, 0, 1.5, 0})
      .add({2.5, 2.0, 0}, {0, 0, 0, 0, 0.5, 0})
      .add({2.5, 2.0, 0}, {0, 0, 0, 0, 1.5, 30});
  builder.batch().heading = {{0, -1, 0}, {0, -1, 0}, {0, -1, 0}};
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(table[0][4], 28.0);
  EXPECT_EQ(table[1][4], 0.0);
  EXPECT_EQ(table[2][4], 0.0);
  EXPECT_EQ(table[0][5], std::nullopt);
}

TEST(Soil, InSpaceTheDirectionPastAStoneComesBack) {
  std::string map;
  for (int row = 0; row < 9; ++row) {
    map += (row == 0 ? "[" : ",[") + std::string(row == 4 ? "0,1,0]" : "0,0,0]");
  }
  const auto process = openProcess(
      "soil", R"({"domainSize":[3,3,3],"concentration":[)" + map + R"(],"sliceCount":3,"obstacleMap":[)" + map + "]}");
  QueryBuilder builder;
  builder.add({1.5, 2.5, 1.5}, {0, 0, 0, 0, 2.0, 0, 0}).add({0.5, 2.5, 0.5}, {0, 0, 0, 0, 2.0, 0, 0});
  builder.batch().heading = {{0, -1, 0}, {0, -1, 0}};
  const auto table = answersOf(*process, builder.batch());
  const core::Vec3 direction{*table[0][4], *table[0][5], *table[0][6]};
  EXPECT_NEAR(core::length(direction), 1.0, 1e-12);
  // it must have left the stone's column before y = 2: half a cell aside in half a cell down, 45° or more
  EXPECT_GE(std::acos(-direction.y) * 180 / std::numbers::pi, 45.0);
  EXPECT_LE(std::acos(-direction.y) * 180 / std::numbers::pi, 48.0);
  EXPECT_EQ(valuesOf(table[1])[5], -1.0);
}

TEST(Soil, TimePassesInStepsWithoutQueries) {
  const auto process = openProcess(
      "soil",
      R"({"domainSize":[2,1,1],"concentration":[[1,0]],"depletion":true,"diffusionSteps":1,"relaxationFactor":1})");
  ASSERT_FALSE(process->tick(1).has_value());
  // a quarter through the one face
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({1.5, 0, 0}, {9}).batch())), std::vector<double>{0.25});
}

TEST(Soil, WrongMapsAreErrors) {
  EXPECT_EQ(errorsOf(makeProcess("soil", R"({"concentration":[[1,2],[3]]})")),
            "error: environment process 'soil': 'concentration[1]' must have 2 numbers, found 1\n"
            "   hint: all maps have one number for each cell");
  EXPECT_EQ(errorsOf(makeProcess("soil", R"({"concentration":[[1,2],[3,4]],"obstacleMap":[[0,1]]})")),
            "error: environment process 'soil': 'obstacleMap' must have 2 rows, found 1\n"
            "   hint: all maps have one number for each cell");
  EXPECT_EQ(errorsOf(makeProcess("soil", R"({"concentration":[[1,2],[3,4],[5,6]],"sliceCount":2})")),
            "error: environment process 'soil': 'concentration' has 3 rows, which are not 2 slices of equal size\n"
            "   hint: sliceCount: number of slices in the rows");
  EXPECT_EQ(errorsOf(makeProcess("soil", R"({"layerThicknesses":[1],"geotropicAngles":[1,2]})")),
            "error: environment process 'soil': there are 1 layer thicknesses and 2 geotropic angles\n"
            "   hint: give one angle for each layer");
  EXPECT_EQ(errorsOf(makeProcess("soil", R"({"gridSize":[4096,4096,4096]})")),
            "error: environment process 'soil': the grid has 68719476736 cells, and the limit is 67108864\n"
            "   hint: use fewer cells along x, y or z");
}

}  // namespace
}  // namespace espalier::environment::soil_test
