#include "environment/geometry/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace espalier::environment::shapes_test {
namespace {

using core::Vec3;

constexpr double kRounding = 1e-12;

void expectNear(const Vec3& found, const Vec3& expected) {
  EXPECT_NEAR(found.x, expected.x, kRounding);
  EXPECT_NEAR(found.y, expected.y, kRounding);
  EXPECT_NEAR(found.z, expected.z, kRounding);
}

// the points of a segment, evenly
template <typename Visit>
void alongSegment(const Vec3& a, const Vec3& b, const Visit& visit) {
  constexpr int kParts = 400;
  for (int i = 0; i <= kParts; ++i) {
    visit(a + (b - a) * (static_cast<double>(i) / kParts));
  }
}

TEST(Shapes, NearestPointsOfASphereOutsideInsideAndAtItsCentre) {
  const Sphere sphere{{1, 2, 3}, 2};
  const SurfacePoint outside = nearestOn(sphere, {1, 7, 3});
  EXPECT_NEAR(outside.distance, 3.0, kRounding);
  expectNear(outside.point, {1, 4, 3});
  expectNear(outside.normal, {0, 1, 0});
  const SurfacePoint inside = nearestOn(sphere, {1.5, 2, 3});
  EXPECT_NEAR(inside.distance, -1.5, kRounding);
  expectNear(inside.point, {3, 2, 3});
  // every direction is as good as another at the centre, but one is chosen
  const SurfacePoint centre = nearestOn(sphere, {1, 2, 3});
  EXPECT_NEAR(centre.distance, -2.0, kRounding);
  EXPECT_NEAR(core::length(centre.normal), 1.0, kRounding);
  EXPECT_NEAR(core::length(centre.point - sphere.centre), 2.0, kRounding);
}

TEST(Shapes, NearestPointsOfACapsuleAreThoseOfItsLineAndItsEnds) {
  const Capsule capsule{{0, 0, 0}, {0, 4, 0}, 1};
  EXPECT_NEAR(nearestOn(capsule, {3, 2, 0}).distance, 2.0, kRounding);
  expectNear(nearestOn(capsule, {3, 2, 0}).point, {1, 2, 0});
  // beyond the end: √(3² + 4²) − 1
  EXPECT_NEAR(nearestOn(capsule, {3, 8, 0}).distance, 4.0, kRounding);
  // a capsule without a length is a sphere
  EXPECT_NEAR(nearestOn(Capsule{{0, 0, 0}, {0, 0, 0}, 1}, {0, 3, 0}).distance, 2.0, kRounding);
  // one without a radius is a line
  EXPECT_NEAR(nearestOn(Capsule{{0, 0, 0}, {0, 4, 0}, 0}, {3, 2, 0}).distance, 3.0, kRounding);
}

TEST(Shapes, NearestPointsOfABoxAreOnFacesEdgesCornersAndInside) {
  const Bounds box{{0, 0, 0}, {2, 4, 6}};
  EXPECT_NEAR(nearestOn(box, {5, 2, 3}).distance, 3.0, kRounding);
  expectNear(nearestOn(box, {5, 2, 3}).normal, {1, 0, 0});
  EXPECT_NEAR(nearestOn(box, {5, 8, 3}).distance, 5.0, kRounding);
  // 3, 4, 12 beyond the corner
  EXPECT_NEAR(nearestOn(box, {5, 8, 18}).distance, 13.0, kRounding);
  const SurfacePoint inside = nearestOn(box, {1, 0.25, 3});
  EXPECT_NEAR(inside.distance, -0.25, kRounding);
  expectNear(inside.point, {1, 0, 3});
  expectNear(inside.normal, {0, -1, 0});
}

TEST(Shapes, AHalfSpaceHasItsDistanceAlongItsNormal) {
  const HalfSpace ground{{0, 1, 0}, {0, 1, 0}};
  EXPECT_NEAR(nearestOn(ground, {7, 4, 9}).distance, 3.0, kRounding);
  expectNear(nearestOn(ground, {7, 4, 9}).point, {7, 1, 9});
  EXPECT_NEAR(nearestOn(ground, {7, -2, 9}).distance, -3.0, kRounding);
  EXPECT_NEAR(distanceTo(ground, {0, 5, 0}, {9, 3, 0}), 2.0, kRounding);
  EXPECT_LE(distanceTo(ground, {0, 5, 0}, {9, 0, 0}), 0.0);
  EXPECT_NEAR(*rayTo(ground, {0, 4, 0}, {0.6, -0.8, 0}), 3.75, kRounding);
  EXPECT_EQ(rayTo(ground, {0, 0, 0}, {0, 1, 0}), 0.0);
  EXPECT_FALSE(rayTo(ground, {0, 4, 0}, {0, 1, 0}).has_value());
  EXPECT_FALSE(rayTo(ground, {0, 4, 0}, {1, 0, 0}).has_value());
}

TEST(Shapes, TheNearestPointOfATriangleKnowsWhereItLies) {
  const Triangle triangle{{Vec3{0, 0, 0}, Vec3{4, 0, 0}, Vec3{0, 4, 0}}};
  EXPECT_EQ(nearestOnTriangle(triangle, {1, 1, 5}).feature, 0);
  expectNear(nearestOnTriangle(triangle, {1, 1, 5}).point, {1, 1, 0});
  // sides from corner 1, 2, 3
  EXPECT_EQ(nearestOnTriangle(triangle, {2, -3, 1}).feature, 1);
  EXPECT_EQ(nearestOnTriangle(triangle, {4, 4, 1}).feature, 2);
  expectNear(nearestOnTriangle(triangle, {4, 4, 1}).point, {2, 2, 0});
  EXPECT_EQ(nearestOnTriangle(triangle, {-3, 2, 1}).feature, 3);
  EXPECT_EQ(nearestOnTriangle(triangle, {-1, -2, 1}).feature, 4);
  EXPECT_EQ(nearestOnTriangle(triangle, {9, 0, 1}).feature, 5);
  EXPECT_EQ(nearestOnTriangle(triangle, {0, 9, 1}).feature, 6);
}

TEST(Shapes, SegmentsAreAsFarApartAsTheirNearestPoints) {
  // skew lines through the axes: apart by the difference in z
  EXPECT_NEAR(segmentDistance({-1, 0, 0}, {1, 0, 0}, {0, -1, 2}, {0, 1, 2}), 2.0, kRounding);
  // parallel, beside and behind each other: √(3² + 4²)
  EXPECT_NEAR(segmentDistance({0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {3, 1, 0}), 1.0, kRounding);
  EXPECT_NEAR(segmentDistance({0, 0, 0}, {2, 0, 0}, {5, 4, 0}, {9, 4, 0}), 5.0, kRounding);
  // without a length: points
  EXPECT_NEAR(segmentDistance({0, 0, 0}, {0, 0, 0}, {3, 4, 0}, {3, 4, 0}), 5.0, kRounding);
  EXPECT_NEAR(segmentDistance({0, 0, 0}, {0, 0, 0}, {-1, 2, 0}, {1, 2, 0}), 2.0, kRounding);
  // crossing ones touch
  EXPECT_NEAR(segmentDistance({-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {1, -1, 0}), 0.0, kRounding);
}

TEST(Shapes, DistancesOfSegmentsAreTheSmallestOfTheirPoints) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-4, 4);
  const auto point = [&] { return Vec3{place(random), place(random), place(random)}; };
  for (int round = 0; round < 200; ++round) {
    const Vec3 a = point();
    const Vec3 b = point();
    const Capsule capsule{point(), point(), 0.3};
    const Sphere sphere{point(), 0.5};
    const Vec3 corner = point();
    const Bounds box{corner, corner + Vec3{0.5, 1.0, 1.5}};
    const Triangle triangle{{point(), point(), point()}};
    std::array<double, 4> smallest{1e9, 1e9, 1e9, 1e9};
    alongSegment(a, b, [&](const Vec3& p) {
      smallest[0] = std::min(smallest[0], nearestOn(capsule, p).distance);
      smallest[1] = std::min(smallest[1], nearestOn(sphere, p).distance);
      smallest[2] = std::min(smallest[2], nearestOn(box, p).distance);
      smallest[3] = std::min(smallest[3], core::length(p - nearestOnTriangle(triangle, p).point));
    });
    const std::array<double, 4> found{distanceTo(capsule, a, b), distanceTo(sphere, a, b), distanceTo(box, a, b),
                                      distanceTo(triangle, a, b)};
    // points are at most 14/400 apart; inside a solid the depth does not matter
    for (std::size_t shape = 0; shape < 4; ++shape) {
      if (smallest[shape] > 0.02) {
        EXPECT_LE(found[shape], smallest[shape] + kRounding) << shape;
        EXPECT_GE(found[shape], smallest[shape] - 0.02) << shape;
      } else {
        EXPECT_LE(found[shape], 0.02) << shape;
      }
    }
  }
}

TEST(Shapes, RaysEndAtTheFirstPointThatIsInside) {
  EXPECT_NEAR(*rayTo(Sphere{{10, 0, 0}, 2}, {0, 0, 0}, {1, 0, 0}), 8.0, kRounding);
  // aside by 1.2 from a radius of 2: √(4 − 1.44) before the middle
  EXPECT_NEAR(*rayTo(Sphere{{10, 1.2, 0}, 2}, {0, 0, 0}, {1, 0, 0}), 8.4, kRounding);
  EXPECT_FALSE(rayTo(Sphere{{10, 2.1, 0}, 2}, {0, 0, 0}, {1, 0, 0}).has_value());
  EXPECT_FALSE(rayTo(Sphere{{-10, 0, 0}, 2}, {0, 0, 0}, {1, 0, 0}).has_value());
  EXPECT_EQ(rayTo(Sphere{{1, 0, 0}, 2}, {0, 0, 0}, {1, 0, 0}), 0.0);
  EXPECT_NEAR(*rayTo(Capsule{{5, -3, 0}, {5, 3, 0}, 1}, {0, 0, 0}, {1, 0, 0}), 4.0, kRounding);
  // the round end: 3 along the axis and a ray beside it by 0.6
  EXPECT_NEAR(*rayTo(Capsule{{5, 0, 0}, {9, 0, 0}, 1}, {0, 0.6, 0}, {1, 0, 0}), 4.2, kRounding);
  EXPECT_NEAR(*rayTo(Bounds{{3, -1, -1}, {5, 1, 1}}, {0, 0, 0}, {1, 0, 0}), 3.0, kRounding);
  EXPECT_EQ(rayTo(Bounds{{-1, -1, -1}, {1, 1, 1}}, {0, 0, 0}, {1, 0, 0}), 0.0);
  // along a face, just outside it
  EXPECT_FALSE(rayTo(Bounds{{3, 1e-9, -1}, {5, 1, 1}}, {0, 0, 0}, {1, 0, 0}).has_value());
  const Triangle triangle{{Vec3{4, -1, -1}, Vec3{4, 2, -1}, Vec3{4, -1, 2}}};
  EXPECT_NEAR(*rayTo(triangle, {0, 0, 0}, {1, 0, 0}), 4.0, kRounding);
  // from behind as well, and not beside it
  EXPECT_NEAR(*rayTo(triangle, {6, 0, 0}, {-1, 0, 0}), 2.0, kRounding);
  EXPECT_FALSE(rayTo(triangle, {0, 3, 0}, {1, 0, 0}).has_value());
  EXPECT_FALSE(rayTo(triangle, {0, 0, 0}, {0, 1, 0}).has_value());
}

TEST(Shapes, BoundsHoldTheShape) {
  const Bounds sphere = boundsOf(Sphere{{1, 2, 3}, 2});
  expectNear(sphere.low, {-1, 0, 1});
  expectNear(sphere.high, {3, 4, 5});
  const Bounds capsule = boundsOf(Capsule{{4, 0, 0}, {0, 0, 2}, 1});
  expectNear(capsule.low, {-1, -1, -1});
  expectNear(capsule.high, {5, 1, 3});
  const Bounds triangle = boundsOf(Triangle{{Vec3{0, 5, 0}, Vec3{4, 0, 0}, Vec3{0, 4, -2}}});
  expectNear(triangle.low, {0, 0, -2});
  expectNear(triangle.high, {4, 5, 0});
}

}  // namespace
}  // namespace espalier::environment::shapes_test
