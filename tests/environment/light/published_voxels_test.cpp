#include "environment/light/published_voxels.h"

#include <gtest/gtest.h>

#include <set>

namespace espalier::environment::published_voxels_test {
namespace {

std::vector<std::uint32_t> visited(PublishedVoxels& voxels, std::size_t own, const FloatVec& direction) {
  std::vector<std::uint32_t> found;
  voxels.visitRay(own, direction, [&](std::uint32_t sphere) { found.push_back(sphere); });
  EXPECT_EQ(std::set(found.begin(), found.end()).size(), found.size());
  return found;
}

// a column of spheres of radius ½, one above the other, with the lowest corner of their box at `low`
std::vector<FloatSphere> column(const FloatVec& low) {
  std::vector<FloatSphere> spheres;
  for (int i = 0; i < 8; ++i) {
    spheres.push_back({low + FloatVec{0.5F, 0.5F + static_cast<float>(i), 0.5F}, 0.5F});
  }
  return spheres;
}

TEST(PublishedVoxels, WhereTheGridBeginsAtTheOriginTheTraversalIsRight) {
  const auto spheres = column({0, 0, 0});
  PublishedVoxels voxels(spheres, {1, 8, 1}, 0.0F);
  const auto found = visited(voxels, 0, {0, 1, 0});
  EXPECT_EQ(std::set(found.begin(), found.end()), (std::set<std::uint32_t>{1, 2, 3, 4, 5, 6, 7}));
  // downwards from the middle nothing that is far above
  const auto below = visited(voxels, 3, {0, -1, 0});
  EXPECT_TRUE(std::set(below.begin(), below.end()).contains(0));
  EXPECT_FALSE(std::set(below.begin(), below.end()).contains(6));
}

TEST(PublishedVoxels, WhereItDoesNotSpheresAreMissed) {
  // The box begins at x = 20, and the border that is taken for that of voxel 0 in x lies at 1: the way to it is 19.5 of
  // the speed 0.7, further than all borders in y. So the ray goes up in y only, although it leaves the box sideways.
  const auto aside = column({20, 0, 0});
  PublishedVoxels voxels(aside, {1, 8, 1}, 0.0F);
  constexpr float kHalf = 0.70710678F;
  EXPECT_EQ(visited(voxels, 0, {kHalf, kHalf, 0}).size(), 7U);
  // at the origin it leaves the grid with its first step, a tie in favour of x, and finds the next sphere only
  const auto spheres = column({0, 0, 0});
  PublishedVoxels others(spheres, {1, 8, 1}, 0.0F);
  EXPECT_EQ(visited(others, 0, {kHalf, kHalf, 0}), std::vector<std::uint32_t>{1});
}

TEST(PublishedVoxels, InAVoxelTheSphereThatWasEnteredLastComesFirst) {
  const auto spheres = column({0, 0, 0});
  PublishedVoxels voxels(spheres, {1, 1, 1}, 0.0F);
  EXPECT_EQ(visited(voxels, 3, {0, 1, 0}), (std::vector<std::uint32_t>{7, 6, 5, 4, 2, 1, 0}));
}

TEST(PublishedVoxels, TheRecordedRayVisitsItsVoxels) {
  // With 8 x 8 x 8 voxels the box of these is (−3, 0, 0) + (7, 6, 4). The ray of the first along (1, 1, 1) visits 412
  // 422 423 424 434 435 445 446 447 457 and ends. A tiny sphere in the middle of each voxel shows where it goes.
  std::vector<FloatSphere> spheres{{{1, 1, 1}, 1}, {{3, 3, 3}, 1}, {{-2, 5, 2}, 1}};
  const auto middle = [](int x, int y, int z) {
    return FloatVec{-3.0F + (static_cast<float>(x) + 0.5F) * 0.875F, (static_cast<float>(y) + 0.5F) * 0.75F,
                    (static_cast<float>(z) + 0.5F) * 0.5F};
  };
  PublishedVoxels voxels(spheres, {8, 8, 8}, 0.0F);
  EXPECT_TRUE(visited(voxels, 0, {0.57735026F, 0.57735026F, 0.57735026F}).empty());
  // a sphere is entered in voxels whose middle is within half a diagonal, 0.63: in the voxel of its own middle always
  for (const auto& [x, y, z, isMet] :
       {std::tuple{4, 5, 7, true}, {4, 4, 7, true}, {0, 7, 7, false}, {7, 7, 7, false}, {4, 1, 2, true}}) {
    auto more = spheres;
    more.push_back({middle(x, y, z), 1e-3F});
    PublishedVoxels others(more, {8, 8, 8}, 0.0F);
    const auto found = visited(others, 0, {0.57735026F, 0.57735026F, 0.57735026F});
    EXPECT_EQ(std::count(found.begin(), found.end(), 3U) == 1, isMet) << x << y << z;
  }
}

TEST(PublishedVoxels, ABoxWithoutExtentAndADirectionWithoutLengthEnd) {
  const std::vector<FloatSphere> spheres{{{4, 4, 4}, 0}, {{4, 4, 4}, 0}};
  PublishedVoxels voxels(spheres, {8, 8, 8}, 0.0F);
  EXPECT_LE(visited(voxels, 0, {0, 1, 0}).size(), 1U);
  EXPECT_LE(visited(voxels, 0, {0, 0, 0}).size(), 1U);
}

}  // namespace
}  // namespace espalier::environment::published_voxels_test
