#include "engine/core/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/work_meter.h"

namespace espalier::core::polygon_test {
namespace {

// the triangles cover a simple polygon when they are count - 2, all turn as it does, and have its area together
void expectCovered(const std::vector<Vec3>& polygon, const std::string& what) {
  const Vec3 normal = newellNormal(polygon);
  const auto triangles = triangulate(polygon, normal);
  ASSERT_EQ(triangles.size(), polygon.size() - 2) << what;
  double area = 0.0;
  for (const auto& t : triangles) {
    const Vec3 side = cross(polygon[t[1]] - polygon[t[0]], polygon[t[2]] - polygon[t[0]]);
    const double part = dot(side, normalised(normal));
    EXPECT_GE(part, -1e-12) << what;
    area += part;
  }
  EXPECT_NEAR(area, length(normal), 1e-9 * length(normal)) << what;
}

std::vector<Vec3> star(int points, double inner) {
  std::vector<Vec3> polygon;
  for (int k = 0; k < 2 * points; ++k) {
    const double angle = std::numbers::pi * k / points;
    const double radius = k % 2 == 0 ? 1.0 : inner;
    polygon.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  }
  return polygon;
}

TEST(Polygon, ConcavePolygonsAreCoveredExactly) {
  expectCovered({{0, 0, 0}, {4, 0, 0}, {4, 1, 0}, {1, 1, 0}, {1, 3, 0}, {4, 3, 0}, {4, 4, 0}, {0, 4, 0}}, "C");
  expectCovered({{0, 0, 0}, {2, 2, 0}, {4, 0, 0}, {2, 4, 0}}, "arrow");
  expectCovered(star(5, 0.3), "star");
  expectCovered(star(60, 0.9), "many points");
}

TEST(Polygon, AnySenseAnyPlaneAndAnyFirstCorner) {
  std::vector<Vec3> polygon = star(7, 0.4);
  for (Vec3& p : polygon) {
    p = {100.0 + p.x, 200.0 + 0.6 * p.y, 300.0 + 0.8 * p.y};
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
    expectCovered(polygon, "rotated");
  }
  std::reverse(polygon.begin(), polygon.end());
  expectCovered(polygon, "clockwise");
}

// Koch's island in the xy plane: 3 · 4^steps corners
std::vector<Vec3> snowflake(int steps) {
  std::vector<Vec3> polygon{{0, 0, 0}, {1, 0, 0}, {0.5, 0.5 * std::numbers::sqrt3, 0}};
  for (int step = 0; step < steps; ++step) {
    std::vector<Vec3> finer;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3& a = polygon[i];
      const Vec3 third = (1.0 / 3.0) * (polygon[(i + 1) % polygon.size()] - a);
      const Vec3 outward{0.5 * third.x + 0.5 * std::numbers::sqrt3 * third.y,
                         0.5 * third.y - 0.5 * std::numbers::sqrt3 * third.x, 0.0};
      finer.insert(finer.end(), {a, a + third, a + third + outward, a + 2.0 * third});
    }
    polygon = std::move(finer);
  }
  return polygon;
}

TEST(Polygon, ManyCornersAreCoveredExactly) {
  // 48 corners are compared with each other, more are looked up in a grid
  for (int steps = 2; steps <= 7; ++steps) {
    expectCovered(snowflake(steps), "snowflake " + std::to_string(steps));
  }
  expectCovered(star(10'000, 0.5), "star");
  // a spiral of three rounds, there and back
  std::vector<Vec3> spiral;
  for (int i = 0; i < 600; ++i) {
    const double angle = 0.0314 * i;
    spiral.push_back({(1.0 + angle) * std::cos(angle), (1.0 + angle) * std::sin(angle), 0.0});
  }
  for (int i = 600; i-- > 0;) {
    const double angle = 0.0314 * i;
    spiral.push_back({(0.5 + angle) * std::cos(angle), (0.5 + angle) * std::sin(angle), 0.0});
  }
  expectCovered(spiral, "spiral");
}

TEST(Polygon, ManyCornersThatCrossOneAnotherStillGiveTriangles) {
  std::vector<Vec3> walk;
  for (int i = 0; i < 2000; ++i) {
    walk.push_back({std::sin(12.9898 * i), std::cos(78.233 * i * i), 0.0});
  }
  EXPECT_EQ(triangulate(walk, {0, 0, 1}).size(), 1998U);
  std::vector<Vec3> line;
  for (int i = 0; i < 200; ++i) {
    line.push_back({static_cast<double>(i % 70), 0, 0});
  }
  EXPECT_EQ(triangulate(line, {0, 0, 1}).size(), 198U) << "no area at all";
}

TEST(Polygon, CuttingAPolygonCanBeStopped) {
  class Stopped : public WorkMeter {
   public:
    [[nodiscard]] bool take(std::int64_t /*bytes*/) noexcept override { return true; }
    [[nodiscard]] bool isStopped() const noexcept override { return true; }
  };
  const std::vector<Vec3> polygon = snowflake(5);
  Stopped meter;
  const WorkMeter::Scope scope(&meter);
  EXPECT_THROW(static_cast<void>(triangulate(polygon, {0, 0, 1})), WorkStopped);
}

TEST(Polygon, RepeatedAndCollinearCornersAreAllowed) {
  expectCovered({{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 1, 0}, {0, 0, 0}}, "repeated");
}

TEST(Polygon, APolygonThatCrossesItselfStillGivesTriangles) {
  const std::vector<Vec3> polygon{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {3, 1, 0}};
  EXPECT_EQ(triangulate(polygon, {0, 0, 1}).size(), 3U);
  // no area at all
  const std::vector<Vec3> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(triangulate(line, {0, 1, 0}).size(), 2U);
}

}  // namespace
}  // namespace espalier::core::polygon_test
