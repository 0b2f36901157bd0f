#include "engine/core/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

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

// Each corner that is cut off takes its triangle from the area of the ring, whether it is an ear or not.
void expectCutFromTheRing(const std::vector<Vec3>& polygon, const std::string& what) {
  const auto triangles = triangulate(polygon, {0, 0, 1});
  ASSERT_EQ(triangles.size(), polygon.size() - 2) << what;
  double area = 0.0;
  double size = 0.0;
  for (const auto& t : triangles) {
    const double part = cross(polygon[t[1]] - polygon[t[0]], polygon[t[2]] - polygon[t[0]]).z;
    area += part;
    size += std::abs(part);
  }
  EXPECT_NEAR(area, newellNormal(polygon).z, 1e-9 * size) << what;
}

std::vector<Vec3> crossingWalk(int count) {
  std::vector<Vec3> walk;
  Vec3 at;
  for (int i = 0; i < count; ++i) {
    const double angle = 78.233 * i * i;
    at = at + Vec3{std::cos(angle), std::sin(angle), 0.0};
    walk.push_back(at);
  }
  return walk;
}

TEST(Polygon, ManyCornersThatCrossOneAnotherStillGiveTriangles) {
  std::vector<Vec3> points;
  for (int i = 0; i < 2000; ++i) {
    points.push_back({std::sin(12.9898 * i), std::cos(78.233 * i * i), 0.0});
  }
  expectCutFromTheRing(points, "points of a square");
  expectCutFromTheRing(crossingWalk(10'000), "walk");
  std::vector<Vec3> spikes;
  for (int i = 0; i < 3000; ++i) {
    const double angle = std::numbers::pi / 180.0 * (i % 2 == 0 ? 0.25 * i : 0.25 * i + 179.0);
    spikes.push_back((i == 0 ? Vec3{} : spikes.back()) + Vec3{std::cos(angle), std::sin(angle), 0.0});
  }
  expectCutFromTheRing(spikes, "spikes");
  std::vector<Vec3> line;
  for (int i = 0; i < 200; ++i) {
    line.push_back({static_cast<double>(i % 70), 0, 0});
  }
  EXPECT_EQ(triangulate(line, {0, 0, 1}).size(), 198U) << "no area at all";
  // areas that are no numbers
  std::vector<Vec3> huge = points;
  for (Vec3& p : huge) {
    p = 1e200 * p;
  }
  EXPECT_EQ(triangulate(huge, {0, 0, 1}).size(), 1998U) << "too large";
}

// Goes round the ring and cuts off each corner that is flat or an ear, or after a round without either the one that
// turns most. A convex corner is an ear when no corner that is not convex lies in it.
std::vector<std::array<std::uint32_t, 3>> cutByGoingRound(const std::vector<Vec3>& polygon) {
  const auto doubleArea = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return cross(polygon[b] - polygon[a], polygon[c] - polygon[a]).z;
  };
  std::vector<std::uint32_t> ring(polygon.size());
  std::iota(ring.begin(), ring.end(), 0U);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  while (ring.size() > 3) {
    // the ring begins with the corner that is looked at first
    const std::size_t count = ring.size();
    const auto triangleAt = [&](std::size_t i) {
      return std::array{ring[(i + count - 1) % count], ring[i], ring[(i + 1) % count]};
    };
    std::vector<double> turns;
    for (std::size_t i = 0; i < count; ++i) {
      const auto [a, b, c] = triangleAt(i);
      turns.push_back(doubleArea(a, b, c));
    }
    const auto isEar = [&](std::size_t i) {
      const auto [a, b, c] = triangleAt(i);
      bool isFree = turns[i] > 0.0;
      for (std::size_t j = 0; j < count; ++j) {
        const std::uint32_t k = ring[j];
        isFree = isFree && (turns[j] > 0.0 || k == a || k == b || k == c || doubleArea(a, b, k) < 0.0 ||
                            doubleArea(b, c, k) < 0.0 || doubleArea(c, a, k) < 0.0);
      }
      return isFree;
    };
    std::size_t cut = 0;
    while (cut < count && turns[cut] != 0.0 && !isEar(cut)) {
      ++cut;
    }
    if (cut == count) {
      cut = static_cast<std::size_t>(std::ranges::max_element(turns) - turns.begin());
    }
    triangles.push_back(triangleAt(cut));
    // goes on behind the next corner
    std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(cut), ring.end());
    ring.erase(ring.begin());
    std::rotate(ring.begin(), ring.begin() + 1, ring.end());
  }
  triangles.push_back({ring.back(), ring[0], ring[1]});
  return triangles;
}

TEST(Polygon, ManyCornersAreCutInTheOrderOfGoingRound) {
  for (int count = 64; count < 400; count += 21) {
    EXPECT_EQ(triangulate(crossingWalk(count), {0, 0, 1}), cutByGoingRound(crossingWalk(count))) << count;
    // stars of random rays; those with a second turn cross themselves
    std::vector<Vec3> rays;
    for (int k = 0; k < count; ++k) {
      const double radius = 1.05 + std::sin(12.9898 * k * k);
      const double angle = 2.0 * std::numbers::pi * (count % 2 + 1) * k / count;
      rays.push_back({radius * std::cos(angle), radius * std::sin(angle), 0.0});
    }
    EXPECT_EQ(triangulate(rays, {0, 0, 1}), cutByGoingRound(rays)) << count;
  }
}

TEST(Polygon, CornersThatCrossOneAnotherAreNotLookedAtInEachRound) {
  // counts how often the work asks whether it is to stop: once in 256 corners looked at
  class Counter : public WorkMeter {
   public:
    [[nodiscard]] bool take(std::int64_t /*bytes*/) noexcept override { return true; }
    [[nodiscard]] bool isStopped() const noexcept override {
      ++polls;
      return false;
    }
    mutable int polls = 0;
  };
  const std::vector<Vec3> walk = crossingWalk(16'384);
  Counter counter;
  const WorkMeter::Scope scope(&counter);
  EXPECT_EQ(triangulate(walk, {0, 0, 1}).size(), 16'382U);
  // four looks a corner; a round of all corners for each that is cut off would be some thousands
  EXPECT_GE(counter.polls, 16'384 / 256);
  EXPECT_LT(counter.polls, 4 * 16'384 / 256);
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
