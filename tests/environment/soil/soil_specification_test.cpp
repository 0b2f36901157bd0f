#include <gtest/gtest.h>

#include "engine/core/streams.h"
#include "environment/published/published_environment.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::soil_specification_test {
namespace {

ProcessOrErrors soilOf(const std::string& specification) {
  core::MemoryFileProvider files({{"model.e", "executable: soil -e model.e soil.spec\nturtle position: P: %f %f %f\n"},
                                  {"soil.spec", specification},
                                  // upper row two obstacles, lower row green 51 and white, a source
                                  {"map.pnm", "P3 2 2 255  40 55 70  9 255 9   0 51 0  255 255 255"}});
  std::vector<core::Diagnostic> warnings;
  auto made = makeFromEnvironmentFile("model.e", files, core::Compatibility::Espalier, warnings);
  EXPECT_TRUE(warnings.empty()) << core::formatDiagnostic(warnings.front());
  return made;
}

constexpr const char* kTwo = "domain size: 2 2 1\nposition: 0 0 0\n";

std::vector<double> concentrations(const std::string& specification, const std::vector<core::Vec3>& places) {
  auto made = soilOf("depletion: off\n" + specification);
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
  EXPECT_EQ(concentrations("domain size: 3 2 1\nposition: 0 0 0\narray: 3 2 1  0 10\n1 2 3\n4 5 6\n",
                           {{0.5, 0.5, 0}, {2.5, 0.5, 0}, {0.5, 1.5, 0}, {2.5, 1.5, 0}, {2.5, 1.5, 99}}),
            (std::vector<double>{4, 6, 1, 3, 3}));
}

TEST(SoilSpecification, AnArrayInSpaceIsSliceAfterSlice) {
  EXPECT_EQ(concentrations("domain size: 1 2 2\nposition: 0 0 0\narray: 1 2 2  0 10\n1\n2\n3 4\n",
                           {{0.5, 0.5, 0.5}, {0.5, 1.5, 0.5}, {0.5, 0.5, 1.5}, {0.5, 1.5, 1.5}, {0.5, 1.5, 2.5}}),
            (std::vector<double>{2, 1, 4, 3, 0}));
}

TEST(SoilSpecification, AnImageGivesConcentrationsByItsBrightness) {
  // 5 · (0.299 r + 0.587 g + 0.114 b)/255
  const auto found =
      concentrations(std::string(kTwo) + "image: 0 5 map.pnm\n", {{0.5, 0.5, 0}, {1.5, 0.5, 0}, {0.5, 1.5, 0}});
  EXPECT_NEAR(found[0], 5 * 0.587 * 51 / 255, 1e-12);
  EXPECT_NEAR(found[1], 5, 1e-12);
  EXPECT_NEAR(found[2], 5 * (0.299 * 40 + 0.587 * 55 + 0.114 * 70) / 255, 1e-12);
}

TEST(SoilSpecification, WithKindsAnImageHasItsConcentrationInGreen) {
  EXPECT_EQ(concentrations(std::string(kTwo) + "obstacles and sources: on\nimage: 1 6 map.pnm\n",
                           {{0.5, 0.5, 0}, {1.5, 0.5, 0}}),
            (std::vector<double>{2, 6}));
}

// everything is taken from a source at the lower right, which gets it back; what flows to the left, of a unit
double flowFromSource(const std::string& specification) {
  auto made = soilOf(kTwo + specification + "diffusion: 1\nrelaxation factor: 1\n");
  EXPECT_EQ(errorsOf(made), "");
  const auto& process = made.value();
  EXPECT_FALSE(process->open({}).has_value());
  answersOf(*process, QueryBuilder().add({1.5, 0.5, 0}, {1}).add({0.5, 0.5, 0}, {1}).batch());
  return firstValues(answersOf(*process, QueryBuilder().add({0.5, 0.5, 0}, {9}).batch()))[0];
}

TEST(SoilSpecification, ObstaclesAndSourcesStandAboveTheArrayOrImage) {
  // a quarter through the face to the left; above are obstacles
  EXPECT_EQ(flowFromSource("obstacles and sources: on\narray: 2 2 1 0 1\n0 -1\n0.5 1\n"), 0.25);
  EXPECT_EQ(flowFromSource("obstacles and sources: on\nimage: 0 1 map.pnm\n"), 0.25);
  // below it is too late: the cell was emptied
  EXPECT_EQ(flowFromSource("array: 2 2 1 0 1\n0 0\n0.5 1\nobstacles and sources: on\n"), 0.0);
  EXPECT_EQ(flowFromSource("obstacles and sources: off\narray: 2 2 1 0 1\n0 0\n0.5 1\n"), 0.0);
}

TEST(SoilSpecification, MissingNumbersOfAnArrayAreThoseOfOneCell) {
  EXPECT_EQ(concentrations("domain size: 3 1 1\nposition: 0 0 0\narray: 3\n1 2 3\n", {{0.5, 0.5, 0}, {2.5, 0.5, 0}}),
            (std::vector<double>{1, 3}));
}

TEST(SoilSpecification, DefaultsAreThePublishedPrograms) {
  // the box (−1, −1, −1) + (2, 2, 2) with 6, which a query takes away; inside only
  auto made = soilOf("");
  ASSERT_EQ(errorsOf(made), "");
  ASSERT_FALSE(made.value()->open({}).has_value());
  const auto obtained = [&](const core::Vec3& place) {
    return firstValues(answersOf(*made.value(), QueryBuilder().add(place, {4}).batch()))[0];
  };
  EXPECT_EQ(obtained({-0.9, 0.9, 0}), 4.0);
  EXPECT_EQ(obtained({0.9, -0.9, 0}), 2.0);
  EXPECT_EQ(obtained({0, 0, 0}), 0.0);
  EXPECT_EQ(obtained({1.1, 0, 0}), 0.0);
}

TEST(SoilSpecification, WrongLinesAreLocatedErrors) {
  EXPECT_EQ(errorsOf(soilOf("array: 3 2 1 0 1\n1 2 3\n")),
            "soil.spec:1:8: error: 'array' needs 6 concentrations on the lines below, found 3\n"
            "    1 | array: 3 2 1 0 1\n      |        ^~~~~~~~~");
  EXPECT_EQ(errorsOf(soilOf("array: 0.5 2 1 0 1\n1 2 3\n")),
            "soil.spec:1:8: error: 'array' needs 1 to 4096 columns, rows and slices\n"
            "    1 | array: 0.5 2 1 0 1\n      |        ^~~~~~~~~~~");
  EXPECT_EQ(
      errorsOf(soilOf("image: 0 1 none.rgb\n")),
      "soil.spec:1:8: error: 'image' names the file 'none.rgb', which cannot be read; it is looked for beside the "
      "specification\n    1 | image: 0 1 none.rgb\n      |        ^~~~~~~~~~~~");
  EXPECT_EQ(errorsOf(soilOf("image: map.pnm 3\n")),
            "soil.spec:1:8: error: 'image' needs the smallest and the largest value and a file, found 'map.pnm 3'\n"
            "    1 | image: map.pnm 3\n      |        ^~~~~~~~~");
}

}  // namespace
}  // namespace espalier::environment::soil_specification_test
