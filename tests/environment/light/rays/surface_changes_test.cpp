#include "environment/light/rays/surface_changes.h"

#include <gtest/gtest.h>

namespace espalier::environment::surface_changes_test {
namespace {

using Numbers = std::vector<std::uint32_t>;
constexpr std::uint32_t kNone = SurfaceChanges::kNone;

/// Triangles at these heights.
LightSurfaces at(const std::vector<double>& heights) {
  LightSurfaces surfaces;
  for (const double height : heights) {
    const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
    surfaces.vertices.insert(surfaces.vertices.end(), {{0, height, 0}, {0, height, 1}, {1, height, 0}});
    surfaces.triangles.push_back({base, base + 1, base + 2});
    surfaces.material.push_back(0);
    surfaces.seed.push_back(7);
    surfaces.thinning.push_back(1);
  }
  return surfaces;
}

TEST(SurfaceChanges, NothingChangesWhenAllIsTheSame) {
  const SurfaceChanges changes = changesBetween(at({1, 2, 3}), at({1, 2, 3}));
  EXPECT_TRUE(changes.isEmpty());
  EXPECT_EQ(changes.earlierOf, (Numbers{0, 1, 2}));
  EXPECT_EQ(changes.laterOf, (Numbers{0, 1, 2}));
}

TEST(SurfaceChanges, WhatComesAndGoesIsFoundWhereverItIs) {
  const SurfaceChanges changes = changesBetween(at({1, 2, 3, 4, 4}), at({9, 1, 3, 8, 4, 4, 4}));
  EXPECT_EQ(changes.earlierOf, (Numbers{kNone, 0, 2, kNone, 3, 4, kNone}));
  EXPECT_EQ(changes.laterOf, (Numbers{1, kNone, 2, 4, 5}));
  // 9, 8, a third 4 and the 2 that went
  EXPECT_EQ(changes.changed.triangles.size(), 4U);
  EXPECT_EQ(changes.changed.vertices.back(), (core::Vec3{1, 2, 0}));
}

TEST(SurfaceChanges, TrianglesKeepTheirOrder) {
  const SurfaceChanges changes = changesBetween(at({1, 2}), at({2, 1}));
  EXPECT_EQ(changes.earlierOf, (Numbers{1, kNone}));
  EXPECT_EQ(changes.changed.triangles.size(), 2U);
}

TEST(SurfaceChanges, AnotherSeedOrThinningOrTurnIsAnotherTriangle) {
  const LightSurfaces one = at({1});
  for (const int what : {0, 1, 2}) {
    LightSurfaces other = one;
    other.seed[0] += what == 0 ? 1U : 0U;
    other.thinning[0] = static_cast<std::uint8_t>(what == 1 ? 0 : 1);
    if (what == 2) {
      other.triangles[0] = {1, 2, 0};
    }
    EXPECT_EQ(changesBetween(one, other).changed.triangles.size(), 2U);
  }
}

}  // namespace
}  // namespace espalier::environment::surface_changes_test
