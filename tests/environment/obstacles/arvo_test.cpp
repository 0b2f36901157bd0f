#include <gtest/gtest.h>

#include <cmath>

#include "engine/core/streams.h"
#include "environment/published/published_environment.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::arvo_test {
namespace {

turtle::QueryBatch at(const core::Vec3& place, const std::vector<double>& parameters, const core::Vec3& heading,
                      const core::Vec3& up) {
  QueryBuilder builder;
  builder.add(place, parameters);
  builder.batch().heading[0] = heading;
  builder.batch().up[0] = up;
  return builder.batch();
}

const std::vector<double> kSeven(7, 0.25);

TEST(Arvo, OnAPlaneTheSegmentGoesStraightOn) {
  const auto process = openProcess("arvo", R"({"planes":[[0,0,0,0,1,0]],"surfaceDistance":0.1})");
  const auto row = answersOf(*process, at({3, 0.1, 3}, kSeven, {1, 0, 0}, {0, 1, 0}))[0];
  EXPECT_EQ(row, (std::vector<std::optional<double>>{1.0, 0.0, 0.0, 0.25, 0.0, 1.0, 0.0}));
}

TEST(Arvo, OnASphereItFollowsTheSurfaceForEver) {
  // radius 2 and distance 0.5: all points stay at 2.5 from the middle, and the way winds around it
  for (const bool isCompatible : {false, true}) {
    const auto process =
        openProcess("arvo", std::string(R"({"spheres":[[0,0,0,2]])") + (isCompatible ? R"(,"compatible":true})" : "}"));
    core::Vec3 place{2.5, 0, 0};
    core::Vec3 heading{0, 1, 0};
    core::Vec3 up{1, 0, 0};
    double turned = 0.0;
    for (int step = 0; step < 80; ++step) {
      const auto row = answersOf(*process, at(place, kSeven, heading, up))[0];
      const double length = *row[3];
      ASSERT_GT(length, 0.0) << step;
      heading = {*row[0], *row[1], *row[2]};
      const core::Vec3 next = place + heading * length;
      turned += std::acos(std::min(core::dot(core::normalised(place), core::normalised(next)), 1.0));
      place = next;
      up = {*row[4], *row[5], *row[6]};
      ASSERT_NEAR(core::length(place), 2.5, 1e-6);
      ASSERT_NEAR(core::length(up - core::normalised(place)), 0.0, 1e-6);
    }
    EXPECT_GT(turned, 6.28);
  }
}

TEST(Arvo, WhereThereIsNoSurfaceTheLengthIs0) {
  const auto process = openProcess("arvo", R"({"spheres":[[0,0,0,2]]})");
  const auto row = answersOf(*process, at({9, 9, 9}, kSeven, {1, 0, 0}, {0, 1, 0}))[0];
  EXPECT_EQ(row, (std::vector<std::optional<double>>{1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0}));
}

TEST(Arvo, FewerParametersAskWhetherASurfaceIsAhead) {
  const auto process = openProcess("arvo", R"({"boxes":[[2,0,-5,3,5,5]]})");
  const auto table = answersOf(*process, at({0, 1, 0}, {2.1, 9, 9, 9}, {1, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{1.0, -1.0, 0.0, 0.0}));
  EXPECT_EQ(answersOf(*process, at({0, 1, 0}, {1.9}, {1, 0, 0}, {0, 1, 0}))[0][0], 0.0);
  EXPECT_EQ(answersOf(*process, at({0, 1, 0}, {2.1}, {-1, 0, 0}, {0, 1, 0}))[0][0], 0.0);
}

TEST(Arvo, QueriesWithoutParametersAddSolids) {
  turtle::EnvironmentContext context;
  context.symbols = {"E", "S", "C"};
  for (const bool forgets : {false, true}) {
    const auto process = openProcess(
        "arvo", std::string(R"({"addObjects":true)") + (forgets ? R"(,"removeObjects":true})" : "}"), context);
    auto adding = at({3, 0, 0}, {}, {0, 1, 0}, {1, 0, 0});
    adding.following = {1};
    adding.followingParameters = {1.0};
    adding.followingOffset = {0, 1};
    answersOf(*process, adding);
    const auto hit = [&] { return *answersOf(*process, at({0, 0, 0}, {9}, {1, 0, 0}, {0, 1, 0}))[0][0]; };
    EXPECT_EQ(hit(), 1.0);
    EXPECT_EQ(hit(), forgets ? 0.0 : 1.0);
  }
}

TEST(Arvo, ASpecificationNamesItsScene) {
  core::MemoryFileProvider files({{"climb.e",
                                   "executable: arvo -e climb.e climb.spec\nturtle position: P: %f %f %f\n"
                                   "turtle heading: H: %f %f %f\nturtle up: U: %f %f %f\n"},
                                  {"climb.spec", "obstacles: stone.scene\nsurface distance: 0.25\ntries for Q: 8\n"},
                                  {"stone.scene", "sphere 2\n"}});
  std::vector<core::Diagnostic> warnings;
  auto made = makeFromEnvironmentFile("climb.e", files, core::Compatibility::Espalier, warnings);
  ASSERT_EQ(errorsOf(made), "");
  EXPECT_TRUE(warnings.empty());
  auto& process = made.value();
  ASSERT_FALSE(process->open({}).has_value());
  const auto row = answersOf(*process, at({2.25, 0, 0}, kSeven, {0, 1, 0}, {1, 0, 0}))[0];
  const core::Vec3 end = core::Vec3{2.25, 0, 0} + core::Vec3{*row[0], *row[1], *row[2]} * *row[3];
  EXPECT_NEAR(core::length(end), 2.25, 1e-9);
}

}  // namespace
}  // namespace espalier::environment::arvo_test
