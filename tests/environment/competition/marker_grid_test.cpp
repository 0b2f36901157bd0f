#include "environment/competition/marker_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace espalier::environment::marker_grid_test {
namespace {

using core::Vec3;

std::vector<MarkerGrid::Marker> randomMarkers(std::mt19937_64& engine, std::size_t count, const Vec3& extent) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::vector<MarkerGrid::Marker> markers;
  for (std::uint32_t i = 0; i < count; ++i) {
    markers.push_back({{share(engine) * extent.x, share(engine) * extent.y, share(engine) * extent.z}, i, i});
  }
  return markers;
}

// the numbers of the markers of a grid within the radius and in the cone, found in the box of the cone
std::set<std::uint32_t> found(const MarkerGrid& grid, const Vec3& apex, const Vec3& heading, double radius,
                              double cosine) {
  std::set<std::uint32_t> numbers;
  grid.visitBox(boxOfCone(apex, heading, radius, cosine), [&](std::size_t slot) {
    const Vec3 offset = grid.markers()[slot].place - apex;
    const double squared = core::dot(offset, offset);
    if (squared <= radius * radius && core::dot(offset, heading) >= cosine * std::sqrt(squared)) {
      EXPECT_TRUE(numbers.insert(grid.markers()[slot].number).second) << "visited twice";
    }
  });
  return numbers;
}

TEST(MarkerGrid, FindsTheMarkersOfEveryConeAlsoWhenSomeAreGone) {
  std::mt19937_64 engine(5);
  for (const Vec3& extent : {Vec3{4.0, 4.0, 4.0}, Vec3{0.0, 30.0, 0.01}, Vec3{1e6, 1e6, 1e6}, Vec3{}}) {
    const std::vector<MarkerGrid::Marker> markers = randomMarkers(engine, 2'000, extent);
    MarkerGrid grid(markers, 1.5);
    std::set<std::uint32_t> left;
    for (const MarkerGrid::Marker& marker : markers) {
      left.insert(marker.number);
    }
    for (int round = 0; round < 300; ++round) {
      std::normal_distribution<double> normal;
      Vec3 heading = core::normalised({normal(engine), normal(engine), normal(engine)});
      if (round % 5 == 0) {
        heading = {0.0, round % 2 == 0 ? 1.0 : -1.0, 0.0};
      }
      if (round % 7 == 0) {
        heading = heading * 1.7;
      }
      const double cosine = round % 6 == 0 ? -2.0 : std::uniform_real_distribution<double>(-1.0, 1.0)(engine);
      const double radius = round % 4 == 0 ? 0.3 : (round % 4 == 1 ? 5.0 : 1.5);
      const Vec3 apex = round % 3 == 0 ? markers[static_cast<std::size_t>(round)].place
                                       : Vec3{normal(engine) * 2.0, normal(engine) * 2.0, normal(engine) * 2.0};
      std::set<std::uint32_t> expected;
      for (const std::uint32_t number : left) {
        const Vec3 offset = markers[number].place - apex;
        const double squared = core::dot(offset, offset);
        if (squared <= radius * radius && core::dot(offset, heading) >= cosine * std::sqrt(squared)) {
          expected.insert(number);
        }
      }
      EXPECT_EQ(found(grid, apex, heading, radius, cosine), expected) << round;
      if (round % 10 == 9) {
        std::erase_if(left, [&](std::uint32_t) { return engine() % 20 == 0; });
        const auto isLeft = [&](const MarkerGrid::Marker& marker) { return left.contains(marker.number); };
        grid.keep(isLeft);
        ASSERT_EQ(grid.markers().size(), left.size());
      }
    }
  }
}

TEST(MarkerGrid, TakesNoMarkersAndMarkersOfAnyDistance) {
  MarkerGrid none({}, 1.0);
  none.visitBox({{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}}, [](std::size_t) { FAIL(); });
  none.keep([](const MarkerGrid::Marker&) { return true; });
  EXPECT_TRUE(none.markers().empty());

  const double far = std::numeric_limits<double>::max();
  const std::vector<MarkerGrid::Marker> markers{{{-far, 0.0, 0.0}, 0, 0}, {{far, far, 0.0}, 1, 1}, {{}, 2, 2}};
  const MarkerGrid grid(markers, 1e-3);
  EXPECT_EQ(found(grid, {}, {0.0, 1.0, 0.0}, 1.0, -2.0), std::set<std::uint32_t>{2});
  EXPECT_EQ(found(grid, {-far, 0.0, 0.0}, {0.0, 1.0, 0.0}, 1.0, -2.0), std::set<std::uint32_t>{0});
}

}  // namespace
}  // namespace espalier::environment::marker_grid_test
