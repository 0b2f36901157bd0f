#include "environment/competition/tip_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

namespace espalier::environment::tip_field_test {
namespace {

using Sums = std::map<std::tuple<std::uint32_t, std::size_t, std::size_t>, double>;

Sums sumsOf(std::vector<PlanePoint> points, const std::vector<PlanePoint>& centres,
            const std::vector<double>& offsets) {
  Sums sums;
  TipField(std::move(points))
      .sumAround(centres, offsets, [&](std::uint32_t centre, std::size_t i, std::size_t j, double sum) {
        EXPECT_TRUE(sums.emplace(std::tuple(centre, i, j), sum).second) << "a place was visited twice";
      });
  return sums;
}

double sumOfAll(const std::vector<PlanePoint>& points, double x, double y) {
  double sum = 0.0;
  for (const PlanePoint& point : points) {
    sum += 1.0 / (1.0 + (x - point.x) * (x - point.x) + (y - point.y) * (y - point.y));
  }
  return sum;
}

/// The largest error of all places over the largest sum.
double errorOf(const std::vector<PlanePoint>& points, const std::vector<PlanePoint>& centres,
               const std::vector<double>& offsets) {
  const Sums sums = sumsOf(points, centres, offsets);
  EXPECT_EQ(sums.size(), centres.size() * offsets.size() * offsets.size());
  double largest = 0.0;
  double error = 0.0;
  for (const auto& [place, sum] : sums) {
    const auto [centre, i, j] = place;
    const double exact = sumOfAll(points, centres[centre].x + offsets[i], centres[centre].y + offsets[j]);
    largest = std::max(largest, exact);
    error = std::max(error, std::abs(sum - exact));
  }
  return error / largest;
}

std::vector<PlanePoint> randomPoints(std::size_t count, double side, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(0.0, side);
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back({place(random), place(random)});
  }
  return points;
}

const std::vector<double> kSix{-0.5, -0.3, -0.1, 0.1, 0.3, 0.5};

TEST(TipField, AgreesWithAllPairsInCrowdsAndDeserts) {
  std::mt19937_64 random(9);
  for (const double side : {0.3, 3.0, 40.0, 1000.0, 1e6}) {
    const auto points = randomPoints(3000, side, random);
    auto centres = randomPoints(100, side, random);
    centres.insert(centres.end(), points.begin(), points.begin() + 100);
    const double error = errorOf(points, centres, kSix);
    EXPECT_LT(error, 1e-6) << "side " << side;
  }
  // a crowd in a desert
  auto points = randomPoints(2000, 500.0, random);
  const auto crowd = randomPoints(2000, 2.0, random);
  points.insert(points.end(), crowd.begin(), crowd.end());
  EXPECT_LT(errorOf(points, {points.begin() + 1900, points.begin() + 2100}, kSix), 1e-6);
}

TEST(TipField, SumsDoNotDependOnTheOrderOfPointsAndCentres) {
  std::mt19937_64 random(10);
  auto points = randomPoints(2000, 20.0, random);
  std::vector<PlanePoint> centres(points.begin(), points.begin() + 300);
  const Sums sums = sumsOf(points, centres, kSix);
  std::shuffle(points.begin(), points.end(), random);
  std::reverse(centres.begin(), centres.end());
  for (const auto& [place, sum] : sumsOf(points, centres, kSix)) {
    const auto [centre, i, j] = place;
    ASSERT_EQ(sum, sums.at({299 - centre, i, j}));
  }
}

TEST(TipField, PointsAtOnePlaceAndNoPointsAtAllAreNoError) {
  // 5000 points at the origin: 5000/(1 + d²)
  const std::vector<PlanePoint> same(5000, PlanePoint{0.0, 0.0});
  EXPECT_LT(errorOf(same, std::vector<PlanePoint>(50, PlanePoint{3.0, 4.0}), {0.0}), 1e-6);
  EXPECT_LT(errorOf(same, {{0.0, 0.0}}, {0.0}), 1e-6);
  EXPECT_EQ(sumsOf({}, {{0.0, 0.0}}, {0.0}).at({0, 0, 0}), 0.0);
  EXPECT_TRUE(sumsOf({{0.0, 0.0}}, {}, {0.0}).empty());
}

}  // namespace
}  // namespace espalier::environment::tip_field_test
