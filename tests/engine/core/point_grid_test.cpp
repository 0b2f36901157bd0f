#include "engine/core/point_grid.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace espalier::core::point_grid_test {
namespace {

using Point = PointGrid::Point;

bool isInside(const Point& p, const std::array<Point, 3>& triangle) {
  int positive = 0;
  int negative = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Point& a = triangle[i];
    const Point& b = triangle[(i + 1) % 3];
    const double side = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    positive += side > 0.0 ? 1 : 0;
    negative += side < 0.0 ? 1 : 0;
  }
  return positive == 0 || negative == 0;
}

TEST(PointGrid, LooksAtAllPointsOfATriangle) {
  std::mt19937_64 random(5);  // NOLINT(cert-msc51-cpp): the same points in each run
  std::uniform_real_distribution<double> place(-3.0, 5.0);
  std::vector<Point> points;
  for (int i = 0; i < 2000; ++i) {
    points.push_back({place(random), 0.01 * place(random)});
  }
  PointGrid grid(points);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    grid.insert(i);
  }
  std::size_t all = 0;
  for (int round = 0; round < 500; ++round) {
    const auto corner = [&] { return points[static_cast<std::size_t>(random() % points.size())]; };
    std::array<Point, 3> triangle{corner(), corner(), corner()};
    if (round % 2 == 0) {
      triangle[2] = {triangle[0][0] + 1e-3, triangle[0][1]};  // a spike
    }
    std::set<std::uint32_t> seen;
    EXPECT_EQ(grid.findNear(triangle[0], triangle[1], triangle[2],
                            [&](std::uint32_t k) {
                              EXPECT_TRUE(seen.insert(k).second) << "twice";
                              return false;
                            }),
              PointGrid::kNone);
    for (std::uint32_t k = 0; k < points.size(); ++k) {
      EXPECT_TRUE(!isInside(points[k], triangle) || seen.contains(k)) << round << ": " << k;
    }
    all += seen.size();
  }
  // half of the triangles are spikes, which touch few cells
  EXPECT_LT(all, 500 * points.size() / 8);
}

TEST(PointGrid, FindsNoPointThatWasRemoved) {
  const std::vector<Point> points{{0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}};
  PointGrid grid(points);
  for (std::uint32_t i = 0; i < 4; ++i) {
    grid.insert(i);
  }
  const auto isThird = [](std::uint32_t k) { return k == 3; };
  EXPECT_EQ(grid.findNear(points[0], points[1], points[2], isThird), 3U);
  grid.remove(3);
  EXPECT_EQ(grid.findNear(points[0], points[1], points[2], isThird), PointGrid::kNone);
}

}  // namespace
}  // namespace espalier::core::point_grid_test
