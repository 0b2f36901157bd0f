// What holds for every built-in process: replies that do not depend on the order of the queries, a state that can be
// saved and restored, and a description that says what is sent and what comes back.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <ostream>
#include <random>

#include "query_builder.h"

namespace espalier::environment {
namespace {

/// A process with a configuration in which its queries matter to each other.
struct Candidate {
  std::string name;
  std::string configuration;
  std::size_t parameterCount;  // of a query, at most
};

void PrintTo(const Candidate& candidate, std::ostream* stream) {
  *stream << candidate.name << " " << candidate.configuration;
}

std::vector<Candidate> candidates() {
  return {
      {"arvo", R"({"spheres":[[5,5,5,3]],"planes":[[0,0,0,0,1,0]],"maxSurfaceDistance":3,"addObjects":true})", 7},
      {"arvo", R"({"spheres":[[5,5,5,3]],"boxes":[[0,0,0,9,1,9]],"compatible":true,"triesForSurface":8})", 7},
      {"attractors", R"({"points":[[1,2,3,4],[9,8,7,-2]]})", 4},
      {"chiba", R"({"radius":1,"sampleCount":8})", 4},
      {"chiba", R"({"radius":1,"sources":[[0,1,0,4],[1,1,0,3]],"estimateIntersectionArea":true,"beamRadius":0.5})", 4},
      {"clover", R"({"gridSize":[64,64],"range":[10,10],"position":[0,0]})", 2},
      {"colonization", R"({"markerCount":2000,"markerBox":[0,0,0,10,10,10],"occupancyRadius":0.4})", 5},
      {"constant", "", 2},
      {"crowding", R"({"samples":20,"leastShare":0.2,"deathProbability":0.5})", 5},
      {"crowding", R"({"extent":[0,10,0,10],"periodic":true,"siteQuality":[[1,0.5]],"competition":"largest"})", 5},
      {"density", "", 3},
      {"density", R"({"onePointValue":true,"returnVector":true})", 3},
      {"density3d", R"({"range":[10,10,10],"gridSize":[5,5,5]})", 1},
      {"ecosystem", "", 2},
      {"ecosystem", R"({"vigor":true,"threeDimensional":true})", 2},
      {"emission", R"({"gridSize":[5,5,5],"cellSize":2,"diffusivity":0.5,"decayRate":0.1,"border":"open"})", 4},
      {"gravity", "", 3},
      {"height", "", 1},
      {"honda", R"({"radius":1})", 2},
      {"light", R"({"sun":"direction","sunDirection":[1,2,0],"directions":32})", 4},
      {"light-voxels", R"({"gridSize":[10,10,10],"voxelSize":1,"position":[0,0,0],"zenithAngles":3})", 5},
      {"light-voxels", R"({"method":"shadow","gridSize":[10,10,10],"voxelSize":1,"position":[0,0,0]})", 4},
      {"meadow", R"({"gridSize":[16,16],"range":[10,10],"position":[0,0],"lightMap":[[0,255],[100,30]]})", 6},
      {"multiple",
       R"({"fields":[{"type":"soil","domainSize":[10,10,10],"gridSize":[4,4,1],"depletion":true},)"
       R"({"type":"chiba","radius":1}]})",
       3},
      {"obstacles",
       R"({"spheres":[[5,5,5,3]],"capsules":[[1,1,1,4,2,9,0.5]],"heightField":[[1,2],[0,1]],)"
       R"("heightFieldExtent":[0,0,10,10],"plants":"remembered"})",
       9},
      {"ornament", R"({"gridSize":[64,64],"range":[10,10],"position":[0,0]})", 2},
      {"shadow", R"({"gridSize":41,"gridSpan":20})", 4},
      {"soil",
       R"({"domainSize":[10,10,10],"gridSize":[6,5,1],"depletion":true,"diffusionSteps":3,)"
       R"("layerThicknesses":[3,4],"geotropicAngles":[20,60]})",
       6},
      {"soil",
       R"({"domainSize":[10,10,10],"concentration":[[1,2,3],[4,0,6],[1,1,1],[0.5,2,2]],"sliceCount":2,)"
       R"("obstacleMap":[[0,0,0],[0,1,0],[0,0,0],[0,0,0]],"sourceMap":[[1,0,0],[0,0,0],[0,0,0],[0,0,1]],)"
       R"("depletion":true,"diffusionSteps":2})",
       7},
      {"soil-water",
       R"({"gridSize":[4,5,3],"cellSize":[2.5,2,3.4],"position":[0,0,0],"spheres":[[5,5,5,2]],"acidity":true,)"
       R"("layers":[[3,0.05,0.4,2,1.6,0.2],[1,0.08,0.43,1,1.4,0.05]],"rain":[[0,0.01],[2,0]],)"
       R"("solutes":[[1,0.5,0.001,0.1,0.2,0.01]]})",
       9},
      {"takenaka", R"({"sources":[[0,100,0,1],[50,80,3,0.5]]})", 2},
      {"wind", R"({"profile":"power"})", 3},
  };
}

std::string nameOf(const testing::TestParamInfo<Candidate>& info) {
  std::string name = info.param.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name + std::to_string(info.index);
}

class ProcessContract : public testing::TestWithParam<Candidate> {};

struct Query {
  core::Vec3 position;
  std::vector<double> parameters;
  std::uint64_t module;
  core::Vec3 heading;
};

/// Queries in a box of 10 with small whole numbers as first parameters, many of them equal.
std::vector<Query> randomQueries(const Candidate& candidate, std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(0.0, 10.0);
  std::uniform_int_distribution<int> few(1, 2);
  // a query of `multiple` has to say which field it is for
  std::uniform_int_distribution<std::size_t> length(candidate.name == "multiple" ? 1 : 0, candidate.parameterCount);
  std::vector<Query> queries;
  for (std::size_t i = 0; i < count; ++i) {
    Query query{{place(random), place(random), place(random)}, {}, i, {place(random), -1.0, 0.5}};
    if (i % 10 == 9) {
      query.position = queries[i / 2].position;
    }
    for (std::size_t k = length(random); k > 0; --k) {
      query.parameters.push_back(query.parameters.empty() ? few(random) : place(random) / 10.0);
    }
    queries.push_back(std::move(query));
  }
  return queries;
}

turtle::QueryBatch batchOf(const std::vector<Query>& queries, const std::vector<std::size_t>& order,
                           std::uint64_t step) {
  QueryBuilder builder;
  for (const std::size_t i : order) {
    builder.add(queries[i].position, queries[i].parameters);
    builder.batch().module.back() = queries[i].module;
    builder.batch().heading.back() = core::normalised(queries[i].heading);
  }
  builder.batch().step = step;
  return builder.batch();
}

std::vector<std::size_t> inOrder(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

TEST_P(ProcessContract, RepliesDoNotDependOnTheOrderOfTheQueries) {
  std::mt19937_64 random(7);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  const auto shuffled = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process && shuffled);
  for (std::uint64_t step = 0; step < 3; ++step) {
    const auto queries = randomQueries(GetParam(), 300, random);
    auto order = inOrder(queries.size());
    const auto expected = answersOf(*process, batchOf(queries, order, step));
    std::shuffle(order.begin(), order.end(), random);
    const auto found = answersOf(*shuffled, batchOf(queries, order, step));
    for (std::size_t k = 0; k < order.size(); ++k) {
      ASSERT_EQ(found[k], expected[order[k]]) << "query " << order[k] << " of step " << step;
    }
    ASSERT_EQ(process->save(), shuffled->save());
  }
}

TEST_P(ProcessContract, ARestoredStateGoesOnAsTheSavedOne) {
  std::mt19937_64 random(11);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  const auto step = [&](turtle::EnvironmentProcess& one, const std::vector<Query>& queries, std::uint64_t number) {
    return answersOf(one, batchOf(queries, inOrder(queries.size()), number));
  };
  for (std::uint64_t number = 0; number < 3; ++number) {
    step(*process, randomQueries(GetParam(), 100, random), number);
  }
  const std::string state = process->save();
  const auto restored = openProcess(GetParam().name, GetParam().configuration);
  const auto error = restored->restore(state);
  ASSERT_FALSE(error.has_value()) << error->message;
  EXPECT_EQ(restored->save(), state);
  for (std::uint64_t number = 3; number < 6; ++number) {
    const auto queries = randomQueries(GetParam(), 100, random);
    ASSERT_EQ(step(*process, queries, number), step(*restored, queries, number));
    ASSERT_FALSE(process->tick(number).has_value());
    ASSERT_FALSE(restored->tick(number).has_value());
  }
  EXPECT_EQ(restored->save(), process->save());

  // opened again it is as new
  ASSERT_FALSE(restored->open({}).has_value());
  EXPECT_EQ(restored->save(), openProcess(GetParam().name, GetParam().configuration)->save());
}

TEST_P(ProcessContract, DamagedStateIsRefusedAndChangesNothing) {
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  if (!process->describe().isStateful) {
    EXPECT_EQ(process->save(), "");
    return;
  }
  const std::string state = process->save();
  const auto error = process->restore(state + "x");
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("saved state"), std::string::npos) << error->message;
  EXPECT_TRUE(process->restore(std::string_view(state).substr(0, state.size() / 2)).has_value());
  EXPECT_EQ(process->save(), state);
}

TEST_P(ProcessContract, DescriptionNamesEveryValueWithItsUnit) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  const auto process = openProcess(GetParam().name, GetParam().configuration, context);
  ASSERT_TRUE(process);
  const auto description = process->describe();
  EXPECT_EQ(description.name, GetParam().name);
  EXPECT_EQ(description.summary.back(), '.');
  for (const auto* variables : {&description.inputs, &description.outputs}) {
    for (const auto& variable : *variables) {
      EXPECT_FALSE(variable.name.empty());
      EXPECT_FALSE(variable.unit.empty()) << variable.name;
      // light is measured per square metre and in micromoles whatever the world's unit
      const bool isOfLight = variable.unit.substr(0, 1) == "W" || variable.unit.substr(0, 4) == "umol";
      EXPECT_TRUE(isOfLight || variable.unit.find('m') == std::string::npos ||
                  variable.unit.find("cm") != std::string::npos)
          << variable.name << " has the unit " << variable.unit << " in a world of centimetres";
    }
  }
}

TEST_P(ProcessContract, AStepWithoutQueriesIsNoError) {
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process);
  EXPECT_TRUE(answersOf(*process, QueryBuilder().batch()).empty());
}

INSTANTIATE_TEST_SUITE_P(Processes, ProcessContract, testing::ValuesIn(candidates()), nameOf);

TEST(ProcessContracts, CoverEveryProcess) {
  const auto all = candidates();
  for (const std::string& name : processNames()) {
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Candidate& one) { return one.name == name; })) << name;
  }
}

}  // namespace
}  // namespace espalier::environment
