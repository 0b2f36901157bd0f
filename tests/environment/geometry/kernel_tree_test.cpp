#include "environment/geometry/kernel_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace espalier::environment::kernel_tree_test {
namespace {

double ofSource(double squared) {
  return 1.0 / (1.0 + std::sqrt(squared));
}

std::vector<WeightedPoint> manyPoints(std::size_t count) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(-50, 50);
  std::uniform_real_distribution<double> weight(-1, 3);
  std::vector<WeightedPoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back({place(random), place(random), weight(random)});
  }
  return points;
}

TEST(KernelTree, SumsAreThoseOfAllPointsToAMillionth) {
  const auto points = manyPoints(5000);
  const KernelTree tree(points, false);
  const KernelTree exact(points, true);
  double largest = 0.0;
  double error = 0.0;
  for (const auto& [x, y] : std::vector<std::pair<double, double>>{{0, 0}, {-50, 50}, {12.5, -3.25}, {200, 10}}) {
    double direct = 0.0;
    for (const WeightedPoint& point : points) {
      direct += point.weight * ofSource(std::pow(x - point.x, 2) + std::pow(y - point.y, 2));
    }
    EXPECT_NEAR(exact.sum(x, y, ofSource) / direct, 1.0, 1e-12);
    largest = std::max(largest, std::abs(direct));
    error = std::max(error, std::abs(tree.sum(x, y, ofSource) - direct));
  }
  EXPECT_LT(error, 1e-6 * largest);
}

TEST(KernelTree, TheOrderOfThePointsDoesNotMatterBitByBit) {
  auto points = manyPoints(2000);
  const KernelTree tree(points, false);
  std::shuffle(points.begin(), points.end(), std::mt19937_64(9));
  const KernelTree shuffled(points, false);
  for (double x = -60; x < 60; x += 7.3) {
    EXPECT_EQ(tree.sum(x, 0.5 * x, ofSource), shuffled.sum(x, 0.5 * x, ofSource));
  }
}

TEST(KernelTree, FarPlacesCostAFewEvaluations) {
  const KernelTree tree(manyPoints(20000), false);
  std::size_t evaluations = 0;
  const auto counted = [&](double squared) {
    ++evaluations;
    return ofSource(squared);
  };
  static_cast<void>(tree.sum(1000, 1000, counted));
  // the 36 nodes of the root
  EXPECT_EQ(evaluations, 36U);
  evaluations = 0;
  static_cast<void>(tree.sum(0, 0, counted));
  EXPECT_LT(evaluations, 5000U);
}

TEST(KernelTree, PointsAtOnePlaceAndNoneAtAll) {
  const KernelTree same(std::vector<WeightedPoint>(1000, {1.0, 2.0, 0.5}), false);
  EXPECT_NEAR(same.sum(4, 6, ofSource), 500.0 / 6.0, 1e-9);
  const KernelTree none({}, false);
  EXPECT_EQ(none.sum(0, 0, ofSource), 0.0);
}

}  // namespace
}  // namespace espalier::environment::kernel_tree_test
