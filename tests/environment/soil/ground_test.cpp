#include "environment/soil/ground.h"

#include <gtest/gtest.h>

#include <limits>

namespace espalier::environment::ground_test {
namespace {

TEST(Ground, PointsFindTheirCellsForAnyDirectionOfUp) {
  const Ground::Shape shape{{-1, -2, 0}, {2, 4, 3}, {1, 0.5, 2}};
  for (const core::Vec3& up : {core::Vec3{0, 1, 0}, core::Vec3{0, -1, 0}, core::Vec3{1, 0, 0}, core::Vec3{0, 0, -1}}) {
    const Ground ground(shape, *axesOf(up));
    for (std::size_t cell = 0; cell < 24; ++cell) {
      EXPECT_EQ(ground.cellOf(ground.middleOf(cell)), cell);
    }
    // all borders belong to the box
    EXPECT_EQ(ground.cellOf({1, 0, 6}), ground.cellOf({0.9, -0.1, 5.9}));
    EXPECT_EQ(ground.cellOf({-1, -2, 0}), ground.cellOf({-0.9, -1.9, 0.1}));
    EXPECT_FALSE(ground.cellOf({1.001, 0, 0}).has_value());
    EXPECT_FALSE(ground.cellOf({0, 0.001, 0}).has_value());
    EXPECT_FALSE(ground.cellOf({0, -2.1, 0}).has_value());
    // the last cell is the highest, half a cell below the top
    EXPECT_EQ(ground.depthOf(23) * 2, ground.solverShape().heights[0]);
    EXPECT_GT(core::dot(ground.middleOf(23), up), core::dot(ground.middleOf(0), up));
  }
}

TEST(Ground, GradientsAreInWorldCoordinates) {
  for (const core::Vec3& up : {core::Vec3{0, 1, 0}, core::Vec3{0, -1, 0}, core::Vec3{1, 0, 0}, core::Vec3{0, 0, -1}}) {
    const Ground ground({{0, 0, 0}, {3, 3, 3}, {1, 0.5, 2}}, *axesOf(up));
    const RichardsSolver water(ground.solverShape(), {SoilLayer{}}, std::vector<int>(27, 0));
    const auto value = [&](std::size_t cell) { return core::dot(ground.middleOf(cell), {1, 2, -3}); };
    const auto middle = ground.cellOf({1.5, 0.75, 3});
    const core::Vec3 gradient = ground.gradientAt(*middle, water, value);
    EXPECT_NEAR(gradient.x, 1, 1e-14);
    EXPECT_NEAR(gradient.y, 2, 1e-14);
    EXPECT_NEAR(gradient.z, -3, 1e-14);
  }
}

TEST(RateSeries, ARateStaysUntilTheNextAndRepeats) {
  const RateSeries once({{2, 5}, {4, 0}}, 0);
  EXPECT_EQ(once.at(1.9), 0);
  EXPECT_EQ(once.at(2), 5);
  EXPECT_EQ(once.at(9), 0);
  EXPECT_EQ(once.remaining(1.5), 0.5);
  EXPECT_EQ(once.remaining(4), std::numeric_limits<double>::infinity());
  const RateSeries weekly({{2, 5}, {4, 1}}, 7);
  EXPECT_EQ(weekly.at(7.5), 1);
  EXPECT_EQ(weekly.at(9.5), 5);
  EXPECT_EQ(weekly.remaining(13), 1);
  EXPECT_EQ(RateSeries().at(3), 0);
}

}  // namespace
}  // namespace espalier::environment::ground_test
