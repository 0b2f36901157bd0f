#include <gtest/gtest.h>

#include "engine/core/streams.h"
#include "environment/published/published_environment.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment {
namespace {

ProcessOrErrors soilOf(const std::string& specification) {
  core::MemoryFileProvider files({{"model.e", "executable: soil -e model.e soil.spec\nturtle position: P: %f %f %f\n"},
                                  {"soil.spec", specification},
                                  // upper row red (an obstacle), lower row green 51 and 255 (a source)
                                  {"map.pnm", "P3 2 2 255  255 0 0  255 0 0   0 51 0  0 255 0"}});
  std::vector<core::Diagnostic> warnings;
  auto made = makeFromEnvironmentFile("model.e", files, core::Compatibility::Espalier, warnings);
  EXPECT_TRUE(warnings.empty()) << core::formatDiagnostic(warnings.front());
  return made;
}

std::vector<double> concentrations(const std::string& specification, const std::vector<core::Vec3>& places) {
  auto made = soilOf(specification);
  EXPECT_EQ(errorsOf(made), "");
  if (!errorsOf(made).empty()) {
    return {};
  }
  const auto& process = made.value();
  EXPECT_FALSE(process->open({}).has_value());
  QueryBuilder builder;
  for (const core::Vec3& place : places) {
    builder.add(place, {1e9});
  }
  return firstValues(answersOf(*process, builder.batch()));
}

TEST(SoilSpecification, AnArrayHasItsHighestRowFirst) {
  EXPECT_EQ(concentrations("domain size: 3 2 1\narray: 3 2 1  0 10\n1 2 3\n4 5 6\n",
                           {{0.5, 0.5, 0}, {2.5, 0.5, 0}, {0.5, 1.5, 0}, {2.5, 1.5, 0}, {2.5, 1.5, 99}}),
            (std::vector<double>{4, 6, 1, 3, 3}));
}

TEST(SoilSpecification, AnArrayInSpaceIsSliceAfterSlice) {
  EXPECT_EQ(concentrations("domain size: 1 2 2\narray: 1 2 2  0 10\n1\n2\n3 4\n",
                           {{0.5, 0.5, 0.5}, {0.5, 1.5, 0.5}, {0.5, 0.5, 1.5}, {0.5, 1.5, 1.5}, {0.5, 1.5, 2.5}}),
            (std::vector<double>{2, 1, 4, 3, 0}));
}

TEST(SoilSpecification, AnImageGivesConcentrationsInItsGreen) {
  EXPECT_EQ(concentrations("domain size: 2 2 1\nimage: map.pnm 0 5\n", {{0.5, 0.5, 0}, {1.5, 0.5, 0}, {0.5, 1.5, 0}}),
            (std::vector<double>{1, 5, 0}));
}

TEST(SoilSpecification, AnImageGivesObstaclesInRedAndSourcesInGreen) {
  auto made = soilOf(
      "domain size: 2 2 1\narray: 2 2 1 0 1\n0 0\n0 1\nobstacles and sources: map.pnm\ndepletion: on\ndiffusion: 1\n"
      "relaxation factor: 1\n");
  ASSERT_EQ(errorsOf(made), "");
  const auto& process = made.value();
  ASSERT_FALSE(process->open({}).has_value());
  // everything is taken from the source, which gets it back and gives a quarter to the left, nothing upwards
  answersOf(*process, QueryBuilder().add({1.5, 0.5, 0}, {1}).batch());
  EXPECT_EQ(
      firstValues(answersOf(
          *process, QueryBuilder().add({0.5, 0.5, 0}, {9}).add({1.5, 0.5, 0}, {9}).add({1.5, 1.5, 0}, {9}).batch())),
      (std::vector<double>{0.25, 0.75, 0.0}));
}

TEST(SoilSpecification, WrongLinesAreLocatedErrors) {
  EXPECT_EQ(
      errorsOf(soilOf("array: 3 2 1\n")),
      "soil.spec:1:8: error: 'array' needs 5 numbers, columns, rows, slices, smallest and largest value, found 3\n"
      "    1 | array: 3 2 1\n      |        ^~~~~");
  EXPECT_EQ(errorsOf(soilOf("array: 3 2 1 0 1\n1 2 3\n")),
            "soil.spec:1:8: error: 'array' needs 6 concentrations on the lines below, found 3\n"
            "    1 | array: 3 2 1 0 1\n      |        ^~~~~~~~~");
  EXPECT_EQ(errorsOf(soilOf("array: 0.5 2 1 0 1\n1 2 3\n")),
            "soil.spec:1:8: error: 'array' needs whole numbers of columns, rows and slices, 1 to 4096\n"
            "    1 | array: 0.5 2 1 0 1\n      |        ^~~~~~~~~~~");
  EXPECT_EQ(
      errorsOf(soilOf("image: none.rgb\n")),
      "soil.spec:1:8: error: 'image' names the file 'none.rgb', which cannot be read; it is looked for beside the "
      "specification\n    1 | image: none.rgb\n      |        ^~~~~~~~");
  EXPECT_EQ(errorsOf(soilOf("image: map.pnm 3\n")),
            "soil.spec:1:8: error: 'image' needs the smallest and the largest value after the file's name, or neither\n"
            "    1 | image: map.pnm 3\n      |        ^~~~~~~~~");
  EXPECT_EQ(errorsOf(soilOf("diffusion: much\n")),
            "soil.spec:1:12: error: 'diffusion' needs a number of steps, found 'much'\n"
            "    1 | diffusion: much\n      |            ^~~~");
  EXPECT_EQ(errorsOf(soilOf("image:\n")),
            "soil.spec:1:1: error: 'image' names no image file\n    1 | image:\n      | ^~~~~");
}

}  // namespace
}  // namespace espalier::environment
