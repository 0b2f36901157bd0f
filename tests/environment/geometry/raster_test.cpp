#include <gtest/gtest.h>

#include "engine/core/streams.h"
#include "environment/published/published_environment.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::raster_test {
namespace {

/// The process of a specification of `clover`, with the picture `light.pnm`: two by two pixels, the first row on top.
ProcessOrErrors cloverOf(const std::string& specification, std::vector<core::Diagnostic>& warnings) {
  core::MemoryFileProvider files({{"m/model.e", "executable: clover -e model.e clover.spec\n"},
                                  {"m/clover.spec", specification},
                                  {"m/light.pnm", "P3 2 2 255  128 255 0  64 51 0   0 0 0  255 102 0"},
                                  {"m/broken.pnm", "P3 2 2 255 1"}});
  return makeFromEnvironmentFile("m/model.e", files, core::Compatibility::Cpfg, warnings);
}

std::vector<std::optional<double>> answerAt(const std::string& specification, const core::Vec3& place) {
  std::vector<core::Diagnostic> warnings;
  auto made = cloverOf(specification, warnings);
  EXPECT_EQ(errorsOf(made), "");
  EXPECT_TRUE(warnings.empty());
  if (!errorsOf(made).empty()) {
    return {};
  }
  const auto& process = made.value();
  EXPECT_FALSE(process->open({}).has_value());
  return answersOf(*process, QueryBuilder().add({}, {0, 0}).batch())[0].empty()
             ? std::vector<std::optional<double>>{}
             : answersOf(*process, QueryBuilder().add(place, {0, 0}).batch())[0];
}

TEST(Raster, TheInputImageGivesTheLightInItsGreenAndTheSecondValueInItsRed) {
  // no turtle position is sent: every query asks at the origin, here over the upper right pixel: green 51, red 64
  EXPECT_EQ(answerAt("grid position: -9 -9\ngrid range: 10x10\ngrid size: 4x4\ninput image: light.pnm\n", {}),
            (std::vector<std::optional<double>>{0.2, 0.5}));
  // and here over the lower left one
  EXPECT_EQ(answerAt("grid position: -1 -1\ngrid range: 10x10\ngrid size: 4x4\ninput image: light.pnm\n", {}),
            (std::vector<std::optional<double>>{0.0, 0.0}));
}

TEST(Raster, DefaultsAreThePublishedPrograms) {
  EXPECT_EQ(answerAt("", {}), (std::vector<std::optional<double>>{1.0, 0.0}));
}

TEST(Raster, ImagesThatCannotBeReadAreLocatedErrors) {
  std::vector<core::Diagnostic> warnings;
  EXPECT_EQ(
      errorsOf(cloverOf("input image: none.png\n", warnings)),
      "m/clover.spec:1:14: error: 'input image' names the file 'm/none.png', which cannot be read; it is looked for "
      "beside the specification\n    1 | input image: none.png\n      |              ^~~~~~~~");
  EXPECT_EQ(
      errorsOf(cloverOf("input image: broken.pnm\n", warnings)),
      "m/clover.spec:1:14: error: 'input image' names the file 'm/broken.pnm', which cannot be used: the file ends "
      "before the picture is complete\n    1 | input image: broken.pnm\n      |              ^~~~~~~~~~");
}

TEST(Raster, CellsBelongToTheirLowBorders) {
  const auto process = openProcess("ornament", R"({"range":[4,4],"position":[-2,-2],"gridSize":[4,4],)"
                                               R"("lightMap":[[1,2,3,4],[5,6,7,8],[9,10,11,12],[13,14,15,16]]})");
  const auto lightAt = [&](double x, double y) {
    return *answersOf(*process, QueryBuilder().add({x, y, 0}, {0, 0}).batch())[0][1];
  };
  EXPECT_EQ(lightAt(-2, -2), 13.0);
  EXPECT_EQ(lightAt(0, -2), 15.0);
  EXPECT_EQ(lightAt(1.99, 1.99), 4.0);
  EXPECT_EQ(lightAt(2, 0), 0.0);
  EXPECT_EQ(lightAt(0, 2), 0.0);
  EXPECT_EQ(lightAt(-2.01, 0), 0.0);
}

}  // namespace
}  // namespace espalier::environment::raster_test
