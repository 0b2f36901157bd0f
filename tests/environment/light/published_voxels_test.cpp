#include "environment/light/published_voxels.h"

#include <gtest/gtest.h>

#include <set>

namespace espalier::environment {
namespace {

std::set<std::uint32_t> visited(PublishedVoxels& voxels, const Ray& ray) {
  std::set<std::uint32_t> found;
  voxels.visitRay(ray, [&](std::uint32_t sphere) { EXPECT_TRUE(found.insert(sphere).second); });
  return found;
}

// a column of spheres of radius ½, one above the other, with the lowest corner of their box at `low`
std::vector<Sphere> column(const core::Vec3& low) {
  std::vector<Sphere> spheres;
  for (int i = 0; i < 8; ++i) {
    spheres.push_back({low + core::Vec3{0.5, 0.5 + i, 0.5}, 0.5});
  }
  return spheres;
}

TEST(PublishedVoxels, WhereTheGridBeginsAtTheOriginTheTraversalIsRight) {
  const auto spheres = column({0, 0, 0});
  PublishedVoxels voxels(spheres, {1, 8, 1});
  const auto found = visited(voxels, {{0.5, 0.5, 0.5}, {0, 1, 0}, 100});
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    EXPECT_TRUE(found.contains(i)) << i;
  }
  // downwards from the middle nothing that is above
  const auto below = visited(voxels, {{0.5, 3.5, 0.5}, {0, -1, 0}, 100});
  EXPECT_TRUE(below.contains(0));
  EXPECT_FALSE(below.contains(6));
}

TEST(PublishedVoxels, WhereItDoesNotSpheresAreMissed) {
  // Sides of a voxel are 1 (x), 1 (y). The box begins at x = 20, so the border that the published traversal takes for
  // that of voxel 0 in x lies at 1, behind the origin 20.5: the way to it is −19.5 along (1, 1, 0)/√2, less than the
  // 0.5 to the border in y. It leaves the grid sideways at once, and everything further up is missed.
  std::vector<Sphere> spheres = column({20, 0, 0});
  PublishedVoxels voxels(spheres, {1, 8, 1});
  const double half = 0.70710678118654752;
  const auto found = visited(voxels, {{20.5, 0.5, 0.5}, {half, half, 0}, 100});
  EXPECT_TRUE(found.contains(0));
  EXPECT_FALSE(found.contains(2));
  // straight up no border in x is asked for, so nothing is missed
  EXPECT_EQ(visited(voxels, {{20.5, 0.5, 0.5}, {0, 1, 0}, 100}).size(), spheres.size());
}

TEST(PublishedVoxels, ASphereOfManyVoxelsIsVisitedOnceByEachRay) {
  const std::vector<Sphere> spheres{{{4, 4, 4}, 4}};
  PublishedVoxels voxels(spheres, {8, 8, 8});
  for (int ray = 0; ray < 3; ++ray) {
    EXPECT_EQ(visited(voxels, {{4, 0.5, 4}, {0, 1, 0}, 100}).size(), 1U);
  }
}

TEST(PublishedVoxels, ARayFromOutsideBeginsInTheNearestVoxel) {
  const auto spheres = column({0, 0, 0});
  PublishedVoxels voxels(spheres, {1, 8, 1});
  EXPECT_EQ(visited(voxels, {{0.5, -5, 0.5}, {0, 1, 0}, 100}).size(), spheres.size());
  // a direction without a length goes nowhere
  EXPECT_LE(visited(voxels, {{0.5, 0.5, 0.5}, {0, 0, 0}, 100}).size(), 2U);
}

}  // namespace
}  // namespace espalier::environment
