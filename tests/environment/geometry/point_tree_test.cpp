#include "environment/geometry/point_tree.h"

#include <gtest/gtest.h>

#include <random>

namespace espalier::environment::point_tree_test {
namespace {

using core::Vec3;

/// The same by looking at all of them.
std::optional<std::uint32_t> nearestOfAll(const std::vector<Vec3>& points, std::uint32_t point, double most) {
  std::optional<std::uint32_t> nearest;
  for (std::uint32_t other = 0; other < points.size(); ++other) {
    const Vec3 way = points[other] - points[point];
    const double squared = core::dot(way, way);
    if (other != point && (squared < most || (squared == most && !nearest))) {
      most = squared;
      nearest = other;
    }
  }
  return nearest;
}

TEST(PointTree, FindsWhatLookingAtAllPairsFinds) {
  std::mt19937_64 random(5);
  // whole coordinates: many equal distances, many points at one place; halves: few of them
  for (const double unit : {1.0, 0.5, 0.001}) {
    std::uniform_int_distribution<int> place(0, static_cast<int>(12.0 / unit));
    std::vector<Vec3> points;
    for (int i = 0; i < 1500; ++i) {
      const double far = i % 50 == 0 ? 1e6 : 1.0;
      points.push_back({unit * place(random) * far, 0.0, unit * place(random)});
    }
    const PointTree tree(points);
    for (std::uint32_t point = 0; point < points.size(); ++point) {
      for (const double most : {0.0, 0.25, 1.0, 4.0, 1e30}) {
        ASSERT_EQ(tree.nearestOther(point, most), nearestOfAll(points, point, most)) << "point " << point;
      }
    }
  }
}

TEST(PointTree, OfPointsAtOnePlaceTheFirstOtherIsNearest) {
  // looking at all pairs of these would take minutes
  const std::vector<Vec3> points(200'000, Vec3{1.0, 2.0, 3.0});
  const PointTree tree(points);
  for (std::uint32_t point = 1; point < points.size(); ++point) {
    ASSERT_EQ(tree.nearestOther(point, 0.0), 0U);
  }
  EXPECT_EQ(tree.nearestOther(0, 0.0), 1U);
}

TEST(PointTree, APointAloneHasNoNearestOne) {
  const std::vector<Vec3> points{{0, 0, 0}, {3, 0, 0}};
  const PointTree tree(points);
  EXPECT_EQ(tree.nearestOther(0, 8.9), std::nullopt);
  EXPECT_EQ(tree.nearestOther(0, 9.0), 1U);
  EXPECT_EQ(PointTree(std::span(points).first(1)).nearestOther(0, 1e30), std::nullopt);
}

}  // namespace
}  // namespace espalier::environment::point_tree_test
