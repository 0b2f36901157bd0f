#include "environment/output/field_embedding.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/core/streams.h"
#include "environment/output/field_output.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::field_embedding_test {
namespace {

turtle::Field field(const std::string& name, const std::string& unit) {
  return {name, unit, {2, 3, 1}, {-1, -3, 0}, {1, 1, 1}, {-1.0, -2.0, -3.0, -4.0, -5.0, -6.0}};
}

EnvironmentEntry embedded(const std::string& type, const std::string& configuration, core::FileProvider& files) {
  EnvironmentEntry entry{type, type, configuration};
  const auto problem = embedFieldFile(entry, "m/world.json", files);
  EXPECT_FALSE(problem.has_value()) << problem->message;
  return entry;
}

std::string problemOf(const std::string& type, const std::string& configuration, core::FileProvider& files) {
  EnvironmentEntry entry{type, "Ground", configuration};
  const auto problem = embedFieldFile(entry, "m/world.json", files);
  return problem ? problem->message : "";
}

TEST(FieldEmbedding, ASoilBeginsWithTheHeadsOfAFile) {
  core::MemoryFileProvider files;
  files.add("m/water.vti", writeVti(std::vector{field("waterContent", "1"), field("Soil.pressureHead", "m")}));
  files.add("m/water.raw", writeRaw(field("pressureHead", "m")));
  files.add("m/water.raw.json", writeRawHeader(field("pressureHead", "m")));
  for (const std::string file : {"water.vti", "water.raw"}) {
    const auto entry =
        embedded("soil-water", R"({"fieldFile":")" + file + R"(","bottom":"closed","gridSize":[2,3,1]})", files);
    const auto process = openProcess(entry.type, entry.configuration);
    const turtle::Field heads = process->fields()[1];
    EXPECT_EQ(heads.name, "pressureHead");
    EXPECT_EQ(heads.values, field("", "").values);
    EXPECT_EQ(heads.cells, (std::array<std::size_t, 3>{2, 3, 1}));
    EXPECT_EQ(heads.position, (core::Vec3{-1, -3, 0}));
    // and a query sees the one of its cell
    EXPECT_EQ(answersOf(*process, QueryBuilder().add({0.5, -1.5, 0.5}, {0, 0}).batch())[0][1], -4.0);
  }
}

TEST(FieldEmbedding, LightFallsThroughTheLeavesOfAFile) {
  // three voxels of one above the other with the densities 0, 1 and 2, horizontal leaves, light from above: e^(−∫D ds)
  core::MemoryFileProvider files;
  files.add(
      "m/leaves.vti",
      writeVti(std::vector{turtle::Field{"leafAreaDensity", "1/m", {1, 3, 1}, {0, 0, 0}, {1, 1, 1}, {0.0, 1.0, 2.0}}}));
  const auto entry = embedded(
      "light-voxels", R"({"fieldFile":"leaves.vti","directions":[[0,1,0,1]],"leafAngles":"horizontal"})", files);
  const auto process = openProcess(entry.type, entry.configuration);
  const auto rows = answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {0}).add({0.5, 2, 0.5}, {0}).batch());
  EXPECT_NEAR(*rows[0][0], std::exp(-3.0), 1e-12);
  EXPECT_NEAR(*rows[1][0], std::exp(-2.0), 1e-12);
  // an organ is added to them
  const auto more = answersOf(*process, QueryBuilder().add({0.5, 2.5, 0.5}, {1}).add({0.5, 2, 0.5}, {0}).batch());
  EXPECT_NEAR(*more[1][0], std::exp(-3.0), 1e-12);
  EXPECT_EQ(process->fields()[1].values, (std::vector<double>{0.0, 1.0, 3.0}));
}

TEST(FieldEmbedding, AFieldInAnotherUnitThanTheWorldIsRefused) {
  core::MemoryFileProvider files;
  const auto opened = [&](const std::string& type, const turtle::Field& content, const std::string& lengthUnit) {
    files.add("m/field.vti", writeVti(std::vector{content}));
    const auto entry = embedded(type, R"({"fieldFile":"field.vti"})", files);
    auto made = makeProcess(entry.type, entry.configuration);
    EXPECT_EQ(errorsOf(made), "");
    turtle::EnvironmentContext context;
    context.world.lengthUnit = lengthUnit;
    const auto problem = made.value()->open(context);
    return problem ? problem->message : std::string();
  };
  for (const std::string unit : {"m", "1"}) {
    EXPECT_EQ(opened("soil-water", field("pressureHead", unit), "m"), "");
  }
  for (const std::string unit : {"1/m", "m-1", "m^-1", "1/length", "1"}) {
    turtle::Field leaves = field("leafAreaDensity", unit);
    leaves.values.assign(6, 1.0);
    EXPECT_EQ(opened("light-voxels", leaves, "m"), "") << unit;
  }
  EXPECT_EQ(opened("soil-water", field("pressureHead", "kPa"), "m"),
            "Environment 'soil-water' begins with pressure heads in 'kPa', and the world's unit of length is 'm'. Give "
            "the heads "
            "and the places of their cells in m.");
  EXPECT_NE(opened("soil-water", field("pressureHead", "cm"), "m").find("in 'cm'"), std::string::npos);
  turtle::Field leaves = field("leafAreaDensity", "1/cm");
  leaves.values.assign(6, 1.0);
  EXPECT_EQ(opened("light-voxels", leaves, "m"),
            "Environment 'light-voxels' begins with leaf area densities in '1/cm', and the world's unit of length is "
            "'m'. Give the densities in 1/m, with \"fieldUnit\": \"1/m\", and the places of their voxels in m.");
}

TEST(FieldEmbedding, WhatIsWrongWithAFileIsSaid) {
  core::MemoryFileProvider files;
  files.add("m/water.vti", writeVti(std::vector{field("waterContent", "1")}));
  files.add("m/heads.vti", writeVti(std::vector{field("pressureHead", "m")}));
  files.add("m/lonely.raw", "");
  const std::string start = "m/world.json: the field file 'm/";
  EXPECT_EQ(problemOf("soil-water", R"({"fieldFile":"none.vti"})", files),
            start + "none.vti' of the environment 'Ground': it cannot be read");
  EXPECT_EQ(problemOf("soil-water", R"({"fieldFile":"water.vti"})", files),
            start + "water.vti' of the environment 'Ground': it has no field 'pressureHead'");
  EXPECT_EQ(problemOf("soil-water", R"({"fieldFile":"lonely.raw"})", files),
            start + "lonely.raw' of the environment 'Ground': there is no header 'm/lonely.raw.json' beside it");
  EXPECT_EQ(problemOf("soil-water", R"({"fieldFile":"heads.vti","gridSize":[2,4,1]})", files),
            start +
                "heads.vti' of the environment 'Ground': its 'gridSize' is [2,3,1], and the configuration has "
                "[2,4,1]");
  // processes that begin with no field know no such key
  EXPECT_EQ(problemOf("honda", R"({"fieldFile":"heads.vti"})", files), "");
  EXPECT_NE(errorsOf(makeProcess("honda", R"({"fieldFile":"heads.vti"})")), "");
}

TEST(FieldEmbedding, ProcessesCountTheirCells) {
  EXPECT_NE(errorsOf(makeProcess("soil-water", R"({"gridSize":[1,3,1],"initialHeads":[-1,-2]})"))
                .find("'initialHeads' has 2 numbers for 3 cells"),
            std::string::npos);
  EXPECT_NE(errorsOf(makeProcess("light-voxels", R"({"gridSize":[1,3,1],"leafAreaDensity":[1,2]})"))
                .find("'leafAreaDensity' has 2 numbers for 3 voxels"),
            std::string::npos);
}

}  // namespace
}  // namespace espalier::environment::field_embedding_test
