#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "engine/core/streams.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/geometry/shapes.h"
#include "environment/output/mesh_embedding.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::obstacles_test {
namespace {

constexpr const char* kWall = R"({"boxes":[[2,0,-5,3,5,5]],"reach":50)";

std::string wall(const std::string& more = "") {
  return kWall + (more.empty() ? "" : "," + more) + "}";
}

turtle::QueryBatch asking(const std::vector<core::Vec3>& places, const std::vector<double>& parameters,
                          const core::Vec3& heading, const std::vector<std::uint32_t>& plants = {}) {
  QueryBuilder builder;
  for (std::size_t i = 0; i < places.size(); ++i) {
    builder.add(places[i], parameters);
    builder.batch().heading.back() = heading;
    builder.batch().plant.back() = i < plants.size() ? plants[i] : 0;
  }
  return builder.batch();
}

TEST(Obstacles, ASegmentGrowsWhenItsCapsuleIsClear) {
  const auto process = openProcess("obstacles", wall());
  const auto mayGrow = [&](double length, double radius) {
    return *answersOf(*process, asking({{0, 1, 0}}, {length, radius}, {1, 0, 0}))[0][0];
  };
  EXPECT_EQ(mayGrow(1.8, 0.1), 1.0);
  EXPECT_EQ(mayGrow(1.8, 0.3), 0.0);
  EXPECT_EQ(mayGrow(2.5, 0.0), 0.0);
  EXPECT_EQ(mayGrow(9.0, 0.0), 0.0);
}

TEST(Obstacles, TheSurroundingsComeBack) {
  const auto process = openProcess("obstacles", wall());
  const auto row = answersOf(*process, asking({{0, 1, 0}}, std::vector<double>(9, 0.0), {0.8, 0.6, 0}))[0];
  // the face x = 2 is 2 away, its normal −x; along the heading it is met at x = 2 after 2/0.8
  EXPECT_EQ(row, (std::vector<std::optional<double>>{1.0, 2.0, 2.0, 1.0, 0.0, -1.0, 0.0, 0.0, 2.5}));
  const auto far = answersOf(*process, asking({{-90, 1, 0}}, std::vector<double>(9, 7.0), {0, 1, 0}))[0];
  EXPECT_EQ(far[1], 50.0);
  EXPECT_EQ(far[2], std::nullopt);
  EXPECT_EQ(far[8], 50.0);
  EXPECT_LT(*answersOf(*process, asking({{2.25, 1, 0}}, {0, 0}, {0, 1, 0}))[0][1], 0.0);
}

TEST(Obstacles, SegmentsOfOtherPlantsBlockEachOther) {
  // two parallel segments 0.5 apart, radii 0.3 each
  const std::vector<core::Vec3> places{{-9, 0, 0}, {-9, 0, 0.5}};
  const auto answers = [&](const std::string& plants, const std::vector<std::uint32_t>& owners) {
    const auto process = openProcess("obstacles", wall(R"("plants":")" + plants + "\""));
    return firstValues(answersOf(*process, asking(places, {1.0, 0.3}, {0, 1, 0}, owners)));
  };
  EXPECT_EQ(answers("ignored", {0, 1}), (std::vector<double>{1, 1}));
  EXPECT_EQ(answers("proposed", {0, 0}), (std::vector<double>{1, 1}));
  EXPECT_EQ(answers("proposed", {0, 1}), (std::vector<double>{0, 0}));
}

TEST(Obstacles, WhatHasGrownIsRemembered) {
  const auto remembering = openProcess("obstacles", wall(R"("plants":"remembered")"));
  EXPECT_EQ(firstValues(answersOf(*remembering, asking({{-9, 0, 0}}, {1.0, 0.3}, {0, 1, 0}, {0}))),
            std::vector<double>{1});
  EXPECT_EQ(firstValues(answersOf(*remembering, asking({{-9, 0, 0.5}, {-9, 0, 0.5}}, {1.0, 0.3}, {0, 1, 0}, {1, 0}))),
            (std::vector<double>{0, 0}));
  EXPECT_EQ(firstValues(answersOf(*remembering, asking({{-9, 0, 0.5}}, {1.0, 0.3}, {0, 1, 0}, {0}))),
            std::vector<double>{1});
}

TEST(Obstacles, WhatIsRememberedDoesNotDependOnTheOrderOfTheQueries) {
  const std::vector<core::Vec3> places{{-9, 0, 0}, {-9, 0, 5}, {-9, 0, 9}};
  const auto stateAfter = [&](const std::vector<std::uint32_t>& order) {
    const auto process = openProcess("obstacles", wall(R"("plants":"remembered")"));
    std::vector<core::Vec3> asked;
    for (const std::uint32_t plant : order) {
      asked.push_back(places[plant]);
    }
    EXPECT_EQ(firstValues(answersOf(*process, asking(asked, {1.0, 0.3}, {0, 1, 0}, order))),
              (std::vector<double>{1, 1, 1}));
    return process->save();
  };
  EXPECT_EQ(stateAfter({2, 0, 1}), stateAfter({0, 1, 2}));
}

TEST(Obstacles, TheLongestSegmentEndsBeforeObstaclesAndOtherPlants) {
  // the wall begins at x = 2; a segment of radius 0.25 touches it when it is 1.75 long
  const std::vector<double> ten{1.0, 0.25, 0, 0, 0, 0, 0, 0, 0, 0};
  const auto process = openProcess("obstacles", wall(R"("plants":"proposed")"));
  EXPECT_NEAR(*answersOf(*process, asking({{0, 1, 0}}, ten, {1, 0, 0}))[0][9], 1.75, 1e-14);
  EXPECT_EQ(answersOf(*process, asking({{1.9, 1, 0}}, ten, {1, 0, 0}))[0][9], 0.0);
  EXPECT_EQ(answersOf(*process, asking({{0, 1, 0}}, ten, {-1, 0, 0}))[0][9], 50.0);
  // an upright segment of plant 1 through (-10, y, 0), radius 0.25: plant 0 may go 10 - 0.5 along -x, plant 1 past it
  QueryBuilder builder;
  builder.add({0, 1, 0}, ten).add({-10, 0.5, 0}, ten).add({0, 1, 0}, ten);
  builder.batch().heading = {{-1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  builder.batch().plant = {0, 1, 1};
  const auto table = answersOf(*process, builder.batch());
  // not even the beginning is clear where the segments of both plants start
  EXPECT_EQ(table[0][9], 0.0);
  builder.batch().position[2] = {0, 1, 9};
  const auto apart = answersOf(*process, builder.batch());
  EXPECT_NEAR(*apart[0][9], 9.5, 1e-14);
  EXPECT_EQ(apart[2][9], 50.0);
}

TEST(Obstacles, WhatOtherPlantsDrawBlocks) {
  // plant 1 draws a cone along y at x = 1, 0.4 thick at its thicker end
  auto geometry = std::make_shared<turtle::Geometry>();
  geometry->segments.plant = {1};
  geometry->start = {{1, 0, 0}};
  geometry->end = {{1, 5, 0}};
  geometry->startWidth = {0.4};
  geometry->endWidth = {0.1};
  const auto process = openProcess("obstacles", wall(R"("plants":"drawn")"));
  EXPECT_TRUE(process->describe().needs.geometry);
  const auto mayGrow = [&](double length, std::uint32_t plant) {
    auto queries = asking({{0, 1, 0}}, {length, 0.1}, {1, 0, 0}, {plant});
    queries.geometry = geometry;
    return *answersOf(*process, queries)[0][0];
  };
  EXPECT_EQ(mayGrow(0.69, 0), 1.0);
  EXPECT_EQ(mayGrow(0.71, 0), 0.0);
  EXPECT_EQ(mayGrow(0.71, 1), 1.0);
  geometry->areWidthsPixels = true;
  EXPECT_EQ(mayGrow(0.89, 0), 1.0);
  EXPECT_EQ(mayGrow(0.91, 0), 0.0);
  // without geometry it does not pretend that there are no plants
  const auto queries = asking({{0, 1, 0}}, {1.0, 0.1}, {1, 0, 0});
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = process->step(queries, replies);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "Environment 'obstacles' needs the geometry of the plants, which did not come with the queries. Set 'plants' "
      "to \"remembered\" instead of \"drawn\" where it cannot be sent.");
}

TEST(Obstacles, RememberedSegmentsBlockAsIfAllWereTriedAgain) {
  // of random segments grown in 40 steps by five plants each new one is compared with all before it, one by one
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> place(-1.5, 1.5);
  const auto process = openProcess("obstacles", R"({"plants":"remembered"})");
  std::vector<std::pair<std::uint32_t, Capsule>> grown;
  std::size_t blockedCount = 0;
  for (int step = 0; step < 40; ++step) {
    QueryBuilder builder;
    for (std::uint32_t plant = 0; plant < 5; ++plant) {
      builder.add({place(random), place(random), place(random)}, {0.5, 0.05});
      builder.batch().plant.back() = plant;
    }
    const auto capsuleOf = [&](std::size_t k) {
      const core::Vec3 from = builder.batch().position[k];
      return Capsule{from, from + builder.batch().heading[k] * 0.5, 0.05};
    };
    const auto answers = firstValues(answersOf(*process, builder.batch()));
    auto next = grown;
    for (std::uint32_t k = 0; k < 5; ++k) {
      auto others = grown;
      for (std::uint32_t other = 0; other < 5; ++other) {
        others.emplace_back(other, capsuleOf(other));
      }
      const Capsule own = capsuleOf(k);
      const bool isClear = std::none_of(others.begin(), others.end(), [&](const auto& other) {
        return other.first != k && segmentDistance(own.a, own.b, other.second.a, other.second.b) <= 0.1;
      });
      ASSERT_EQ(answers[k], isClear ? 1.0 : 0.0) << "step " << step << ", plant " << k;
      blockedCount += isClear ? 0 : 1;
      if (isClear) {
        next.emplace_back(k, own);
      }
    }
    grown = std::move(next);
  }
  EXPECT_GT(blockedCount, 5U);
}

TEST(Obstacles, WrongShapesAreErrors) {
  const auto errors = [](const std::string& configuration) {
    return errorsOf(makeProcess("obstacles", configuration));
  };
  EXPECT_EQ(errors(R"({"spheres":[[0,0,0,-1]]})"),
            "error: environment process 'obstacles': 'spheres[0]' has a negative radius\n"
            "   hint: its last number is the radius");
  EXPECT_EQ(errors(R"({"planes":[[0,0,0,0,0,0]]})"),
            "error: environment process 'obstacles': 'planes[0]' has a normal of no length\n"
            "   hint: its last three numbers are the normal");
  EXPECT_EQ(errors(R"({"boxes":[[0,0,0,1,-1,1]]})"),
            "error: environment process 'obstacles': 'boxes[0]' has a first corner beyond its second\n"
            "   hint: the first corner has the smaller coordinates");
  EXPECT_EQ(errors(R"({"heightField":[[1,2]],"heightFieldExtent":[0,0,1,1]})"),
            "error: environment process 'obstacles': 'heightField' must have at least 2 rows of one length\n"
            "   hint: one height for each corner of the ground's squares");
  EXPECT_EQ(errors(R"({"heightField":[[1,2],[3,4]]})"),
            "error: environment process 'obstacles': 'heightFieldExtent' must be smallest x, smallest z, largest x and "
            "largest z\n   hint: write it as [x0, z0, x1, z1]");
  EXPECT_EQ(errors(R"({"vertices":[[0,0,0]],"triangles":[[0,1,2]]})"),
            "error: environment process 'obstacles': 'triangles' has a corner that is none of its 1 vertices, in "
            "triangle 1\n   hint: a mesh has vertices with three numbers and triangles between them");
  EXPECT_EQ(errors(R"({"vertices":[[0,0,0]]})"),
            "error: environment process 'obstacles': 'triangles' has no triangles\n"
            "   hint: a mesh has vertices with three numbers and triangles between them");
  EXPECT_EQ(errors(R"({"scene":"sphere"})"),
            "error: environment process 'obstacles': 'scene', line 1: 'sphere' needs a radius, found 0 numbers\n"
            "   hint: give the text of a background scene");
  EXPECT_NE(
      errors(R"({"mesh":"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"})").find("environment process 'obstacles': 'mesh': "),
      std::string::npos);
}

TEST(Obstacles, AMeshCanBeTheTextOfAFile) {
  const auto process = openProcess("obstacles", R"({"mesh":"v 0 1 0\nv 2 1 0\nv 0 1 2\nf 1 2 3\n"})");
  EXPECT_NEAR(*answersOf(*process, asking({{0.5, 0, 0.5}}, {0, 0}, {0, 1, 0}))[0][1], 1.0, 1e-12);
}

TEST(MeshEmbedding, AMeshFileBesideTheConfigurationBecomesPartOfIt) {
  core::MemoryFileProvider files;
  files.add("m/rock.obj", "v 0 1 0\nv 2 1 0\nv 0 1 2\nf 1 2 3\n");
  EnvironmentEntry entry{"obstacles", "obstacles", R"({"meshFile":"rock.obj","reach":7})"};
  ASSERT_FALSE(embedMeshFile(entry, "m/world.json", files).has_value());
  EXPECT_EQ(entry.configuration.find("meshFile"), std::string::npos) << entry.configuration;
  EXPECT_NE(entry.configuration.find("\"triangles\":[["), std::string::npos) << entry.configuration;
  EXPECT_NEAR(
      *answersOf(*openProcess(entry.type, entry.configuration), asking({{0.5, 0, 0.5}}, {0, 0}, {0, 1, 0}))[0][1], 1.0,
      1e-12);
  EXPECT_EQ(errorsOf(makeProcess(entry.type, entry.configuration)), "");
  EnvironmentEntry missing{"obstacles", "Rocks", R"({"meshFile":"none.obj"})"};
  EXPECT_EQ(embedMeshFile(missing, "m/world.json", files)->message,
            "m/world.json: the mesh file 'm/none.obj' of the environment 'Rocks': it cannot be read");
  EnvironmentEntry other{"honda", "honda", R"({"radius":1})"};
  EXPECT_FALSE(embedMeshFile(other, "m/world.json", files).has_value());
  EXPECT_EQ(other.configuration, R"({"radius":1})");
}

TEST(Obstacles, VerticesOfAnInlineMeshThatLieAtOnePlaceAreOne) {
  // a tetrahedron whose triangles have three vertices each
  const auto process =
      openProcess("obstacles", R"({"vertices":[[0,0,0],[4,0,0],[0,4,0],[0,0,0],[0,4,0],[0,0,4],[0,0,0],[0,0,4],)"
                               R"([4,0,0],[4,0,0],[0,0,4],[0,4,0]],)"
                               R"("triangles":[[0,1,2],[3,4,5],[6,7,8],[9,10,11]]})");
  const auto row = valuesOf(answersOf(*process, QueryBuilder().add({0.5, 1, 1}, {0.1, 0.05}).batch())[0]);
  EXPECT_EQ(row, (std::vector<double>{0, -0.5}));
}

TEST(Obstacles, SolidsThatTouchKeepTheirInside) {
  // two tetrahedra with vertices of their own and one side in common
  const auto process =
      openProcess("obstacles", R"({"vertices":[[0,0,0],[4,0,0],[0,4,0],[0,0,4],[0,0,0],[4,0,0],[0,-4,0],[0,0,-4]],)"
                               R"("triangles":[[0,2,1],[0,3,2],[0,1,3],[1,2,3],[4,6,5],[4,7,6],[4,5,7],[5,6,7]]})");
  const auto row = valuesOf(answersOf(*process, QueryBuilder().add({0.5, 1, 1}, {0.1, 0.05}).batch())[0]);
  EXPECT_EQ(row, (std::vector<double>{0, -0.5}));
}

}  // namespace
}  // namespace espalier::environment::obstacles_test
