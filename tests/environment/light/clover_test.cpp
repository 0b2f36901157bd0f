#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/environment/query_builder.h"

namespace espalier::environment::clover_test {
namespace {

constexpr const char* kTen = R"({"range":[10,10],"position":[0,0],"gridSize":[100,100],"transmittance":0.5)";

std::string withTen(const std::string& more = "") {
  return kTen + (more.empty() ? "" : "," + more) + "}";
}

double lightAt(turtle::EnvironmentProcess& process, double x, double y) {
  return answersOf(process, QueryBuilder().add({x, y, 0}, {0}).batch())[0][0].value();
}

TEST(Clover, EveryLeafAboveAPointTakesItsPart) {
  // two leaves of area pi (radius 1) at distance 1 from each other: between them both shade, t^2; under one t; beside 1
  const auto process = openProcess("clover", withTen());
  const double pi = std::numbers::pi;
  answersOf(*process, QueryBuilder().add({4, 5, 0}, {1, pi}).add({5, 5, 0}, {1, pi}).batch());
  EXPECT_EQ(lightAt(*process, 4.55, 5.05), 0.25);
  EXPECT_EQ(lightAt(*process, 3.25, 5.05), 0.5);
  EXPECT_EQ(lightAt(*process, 5.75, 5.05), 0.5);
  EXPECT_EQ(lightAt(*process, 2.85, 5.05), 1.0);
}

TEST(Clover, ALeafCoversTheCellsWhoseMiddleItReaches) {
  // of all cells of 0.1, those with the middle within the radius: their area is that of the leaf within a row of cells
  const auto process = openProcess("clover", withTen());
  answersOf(*process, QueryBuilder().add({5, 5, 0}, {1, 4 * std::numbers::pi}).batch());
  double covered = 0.0;
  for (double y = 0.05; y < 10; y += 0.1) {
    for (double x = 0.05; x < 10; x += 0.1) {
      const bool isCovered = lightAt(*process, x, y) < 1.0;
      const double distance = std::hypot(x - 5, y - 5);
      EXPECT_EQ(isCovered, distance <= 2.0) << x << " " << y;
      covered += isCovered ? 0.01 : 0.0;
    }
  }
  EXPECT_NEAR(covered, 4 * std::numbers::pi, 0.1);
}

TEST(Clover, RemovingALeafUndoesAddingIt) {
  const auto process = openProcess("clover", withTen());
  const std::string empty = process->save();
  answersOf(*process, QueryBuilder().add({4, 5, 0}, {1, 3}).add({9.9, 0, 0}, {1, 3}).batch());
  EXPECT_NE(process->save(), empty);
  answersOf(*process, QueryBuilder().add({9.9, 0, 0}, {2, 3}).add({4, 5, 0}, {7, 3}).batch());
  EXPECT_EQ(process->save(), empty);
}

TEST(Clover, LeavesComeBeforeAnswersAndGetNone) {
  const auto process = openProcess("clover", withTen());
  const auto table = answersOf(*process, QueryBuilder().add({5, 5, 0}, {0}).add({5, 5, 0}, {1, 3}).batch());
  EXPECT_EQ(table, (ReplyTable{{0.5}, {std::nullopt, std::nullopt}}));
}

TEST(Clover, MapsGiveTheLightAndTheSecondValue) {
  // two by two values over the raster, the first row far away; p2 is the second value in parts of 128
  const auto process =
      openProcess("clover", withTen(R"("lightMap":[[255,51],[0,102]],"secondMap":[[128,64],[0,255]])"));
  const auto at = [&](double x, double y) {
    return answersOf(*process, QueryBuilder().add({x, y, 0}, {0, 0}).batch())[0];
  };
  EXPECT_EQ(at(1, 9), (std::vector<std::optional<double>>{1.0, 1.0}));
  EXPECT_EQ(at(9, 9), (std::vector<std::optional<double>>{0.2, 0.5}));
  EXPECT_EQ(at(1, 1), (std::vector<std::optional<double>>{0.0, 0.0}));
  EXPECT_EQ(at(9, 1), (std::vector<std::optional<double>>{0.4, 255.0 / 128.0}));
  EXPECT_EQ(at(11, 1), (std::vector<std::optional<double>>{0.0, 0.0}));
}

TEST(Clover, ThePlaneCanBeThatUnderAPlantThatGrowsUpwards) {
  const auto process = openProcess("clover", withTen(R"("plane":"xz")"));
  answersOf(*process, QueryBuilder().add({5, 77, 3}, {1, 1}).batch());
  const auto table = answersOf(*process, QueryBuilder().add({5, 0, 3}, {0}).add({5, 3, 0}, {0}).batch());
  EXPECT_EQ(firstValues(table), (std::vector<double>{0.5, 1.0}));
}

TEST(Clover, OldLeavesCanBeForgotten) {
  const auto process = openProcess("clover", withTen(R"("removeOldLeaves":true)"));
  EXPECT_EQ(firstValues(answersOf(*process, QueryBuilder().add({5, 5, 0}, {0}).add({5, 5, 0}, {1, 3}).batch()))[0],
            0.5);
  EXPECT_EQ(lightAt(*process, 5, 5), 1.0);
}

TEST(Clover, CountsBelow0ShadeNothingUntilLeavesMakeUpForThem) {
  const auto process = openProcess("clover", withTen());
  answersOf(*process, QueryBuilder().add({5, 5, 0}, {2, 3}).batch());
  EXPECT_EQ(lightAt(*process, 5, 5), 1.0);
  answersOf(*process, QueryBuilder().add({5, 5, 0}, {1, 3}).batch());
  EXPECT_EQ(lightAt(*process, 5, 5), 1.0);
}

}  // namespace
}  // namespace espalier::environment::clover_test
