// The worked examples of recorded runs of the published program, and what follows from them.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/environment/query_builder.h"

namespace espalier::environment::published_soil_test {
namespace {

void expectNear(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 5e-7) << i;
  }
}

/// The concentrations of a row of cells of 1 from (0, 0, 0), which are all taken.
std::vector<double> takenFrom(turtle::EnvironmentProcess& process, int count) {
  QueryBuilder builder;
  for (int x = 0; x < count; ++x) {
    builder.add({x + 0.5, 0.5, 0.5}, {1e9});
  }
  return firstValues(answersOf(process, builder.batch()));
}

constexpr const char* kFour =
    R"({"compatible":true,"position":[0,0,0],"domainSize":[4,1,1],"concentration":[[1,0,0,0]])";

TEST(PublishedSoil, ThreeSweepsOfAPlaneField) {
  // from the second sweep on a cell counts itself as one more neighbour
  const auto process = openProcess("soil", std::string(kFour) + R"(,"diffusionSteps":3,"diffusionTolerance":0.9})");
  answersOf(*process, QueryBuilder().add({0.5, 0.5, 0}, {0}).batch());
  expectNear(takenFrom(*process, 4), {0.390625, 0.246528, 0.0694444, 0.0104167});
}

TEST(PublishedSoil, WithMinusOneSweepsEndAtTheTolerance) {
  // two cells 1 and 0: sweep 1 moves both by 0.5 to 0.5, and nothing changes any more; with the tolerance 0.5 a change
  // of 0.5 is not above it, so the cells keep their values
  const auto after = [](const std::string& tolerance) {
    const auto process =
        openProcess("soil", R"({"compatible":true,"position":[0,0,0],"domainSize":[2,1,1],"concentration":[[1,0]],)"
                            R"("diffusionSteps":-1,"diffusionTolerance":)" +
                                tolerance + "}");
    answersOf(*process, QueryBuilder().add({0.5, 0.5, 0}, {0}).batch());
    return takenFrom(*process, 2);
  };
  EXPECT_EQ(after("0.1"), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(after("0.5"), (std::vector<double>{1, 0}));
}

TEST(PublishedSoil, LayersActByTwiceTheirAngleAndEndBelow) {
  const auto process = openProcess(
      "soil",
      R"({"compatible":true,"position":[0,0,0],"domainSize":[4,8,1],"gridSize":[2,2,1],"uniformConcentration":1,)"
      R"("depletion":false,"layerThicknesses":[2,3],"geotropicAngles":[0,30]})");
  const auto answerAt = [&](const core::Vec3& place, const core::Vec3& heading) {
    QueryBuilder builder;
    builder.add(place, {2, 1, 1, 0});
    builder.batch().heading[0] = heading;
    return answersOf(*process, builder.batch())[0];
  };
  expectNear(valuesOf(answerAt({1, 7, 0.5}, {1, 0, 0})), {1, 0, -1, 0});
  expectNear(valuesOf(answerAt({1, 5, 0.5}, {1, 0, 0})), {1, 0.8660254, -0.5, 0});
  expectNear(valuesOf(answerAt({1, 2, 0.5}, {1, 0, 0})), {1, 0, 0, 0});
  expectNear(valuesOf(answerAt({1, 5, 0.5}, {0, -1, 0})), {1, -0.8660254, -0.5, 0});
  // outside the box parameter 1 is 0 and the direction stays as sent; the box of a plane field ends in z too
  EXPECT_EQ(answerAt({1, 5, -0.5}, {1, 0, 0}),
            (std::vector<std::optional<double>>{0.0, std::nullopt, std::nullopt, std::nullopt}));
}

TEST(PublishedSoil, DefaultsAreThoseOfTheProgram) {
  const auto process = openProcess("soil", R"({"compatible":true})");
  QueryBuilder builder;
  builder.add({0.9, 0.9, 0.9}, {4, 1, 1, 0, 0, 0}).add({-0.9, -0.9, 0}, {4, 9}).add({1, 0, 0}, {4, 1, 1, 1, 1, 1});
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(valuesOf(table[0]), (std::vector<double>{4, 0, -1, 0, 0, 999}));
  // two parameters get no direction
  EXPECT_EQ(valuesOf(table[1]), (std::vector<double>{2, 999}));
  EXPECT_EQ(valuesOf(table[2]), (std::vector<double>{0, 999, 999, 999, 0, 0}));
}

TEST(PublishedSoil, ObstaclesCountInGradientsWithTheirValue0) {
  const auto process = openProcess(
      "soil", R"({"compatible":true,"position":[0,0,0],"domainSize":[3,1,1],"concentration":[[0.5,0.5,0.8]],)"
              R"("obstacleMap":[[1,0,0]],"concentrationRange":[0,2],"depletion":false})");
  // (0.8 − 0)/(2 · 2) in the middle; at the border the cell itself counts: (0.8 − 0.5)/4
  const auto table =
      answersOf(*process, QueryBuilder().add({1.5, 0.5, 0}, {0, 0, 1}).add({2.5, 0.5, 0}, {0, 0, 1}).batch());
  EXPECT_NEAR(*table[0][1], 0.2, 1e-7);
  EXPECT_NEAR(*table[1][1], 0.075, 1e-7);
}

TEST(PublishedSoil, QueriesTakeInStringOrder) {
  const auto process = openProcess("soil", std::string(kFour) + "}");
  EXPECT_EQ(
      firstValues(answersOf(*process, QueryBuilder().add({0.5, 0.5, 0}, {0.75}).add({0.5, 0.5, 0}, {0.75}).batch())),
      (std::vector<double>{0.75, 0.25}));
  const auto lasting = openProcess("soil", std::string(kFour) + R"(,"depletion":false})");
  EXPECT_EQ(firstValues(answersOf(*lasting, QueryBuilder().add({0.5, 0.5, 0}, {0.25}).batch())),
            std::vector<double>{1.0});
}

TEST(PublishedSoil, AfterDiffusionObstaclesAndSourcesAreOfNoKindForAStep) {
  const auto process =
      openProcess("soil", R"({"compatible":true,"position":[0,0,0],"domainSize":[3,1,1],"concentration":[[1,0.5,0]],)"
                          R"("sourceMap":[[1,0,0]],"obstacleMap":[[0,0,1]],"diffusionSteps":1})");
  const auto obtained = [&] {
    return firstValues(answersOf(*process, QueryBuilder().add({0.5, 0.5, 0}, {7}).add({2.5, 0.5, 0}, {8}).batch()));
  };
  EXPECT_EQ(obtained(), (std::vector<double>{1, 0}));
  EXPECT_EQ(obtained(), (std::vector<double>{7, 8}));
  // saved and restored the kinds are the same
  const std::string state = process->save();
  const auto third = obtained();
  EXPECT_EQ(third[1], 0.0);
  ASSERT_FALSE(process->restore(state));
  EXPECT_EQ(obtained(), third);
}

TEST(PublishedSoil, TimePassesOnlyWithQueries) {
  const auto process = openProcess("soil", std::string(kFour) + R"(,"diffusionSteps":1})");
  const std::string before = process->save();
  ASSERT_FALSE(process->tick(1));
  answersOf(*process, QueryBuilder().batch());
  EXPECT_EQ(process->save(), before);
}

}  // namespace
}  // namespace espalier::environment::published_soil_test
