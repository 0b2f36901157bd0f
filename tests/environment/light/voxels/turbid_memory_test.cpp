#include "environment/light/voxels/turbid_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace espalier::environment::turbid_memory_test {
namespace {

using core::Vec3;

const VoxelField::Shape kShape{{0, 0, 0}, {40, 40, 40}, 1.0, false};
const Vec3 kPlace{20.5, 20.5, 20.5};
const std::vector<Vec3> kUp{{0, 1, 0}};
const std::vector<Vec3> kAside{{0.6, 0.8, 0}};

/// A memory in which places had their number from each direction on each of 3 rays, and then this voxel changed.
class Remembering {
 public:
  Remembering(const std::vector<Vec3>& places, const std::vector<Vec3>& directions,
              const std::optional<VoxelField::Voxel>& changed, const VoxelField::Shape& shape = kShape) {
    VoxelField field(shape, GridAxes{});
    memory_.begin(field, shape, directions);
    for (std::size_t place = 0; place < std::max<std::size_t>(places.size(), 8); ++place) {
      // more of one place than changes, so that keeping is worth it
      const auto parts = memory_.lookAt(places[place % places.size()], 3).parts;
      std::fill(parts.begin(), parts.end(), static_cast<double>(place % places.size()));
    }
    if (changed) {
      field.values()[*field.indexOf(*changed)] = 7.0;
    }
    memory_.begin(field, shape, directions);
  }
  TurbidMemory::Place at(const Vec3& place, std::size_t rays = 3) { return memory_.lookAt(place, rays); }

 private:
  TurbidMemory memory_;
};

/// Whether the only direction of a place has to be traced after a change.
bool isTraced(const Vec3& place, const std::vector<Vec3>& directions, const VoxelField::Voxel& changed,
              const VoxelField::Shape& shape = kShape) {
  Remembering memory({place}, directions, changed, shape);
  return TurbidMemory::isTouched(memory.at(place), 0);
}

TEST(TurbidMemory, WhatDidNotChangeIsTheSame) {
  Remembering memory({kPlace, {1, 2, 3}}, kUp, std::nullopt);
  const TurbidMemory::Place known = memory.at({1, 2, 3});
  EXPECT_EQ(std::vector<double>(known.before.begin(), known.before.end()), (std::vector<double>{1, 1, 1}));
  EXPECT_EQ(known.parts.size(), 3U);
  EXPECT_FALSE(TurbidMemory::isTouched(known, 0));
  EXPECT_EQ(memory.at({1, 2, 3}, 1).before.size(), 1U) << "fewer rays than are known";
  EXPECT_TRUE(memory.at({1, 2, 3}, 5).before.empty()) << "more than are known";
  EXPECT_TRUE(TurbidMemory::isTouched(memory.at({1, 2, 3}, 5), 0));
  EXPECT_TRUE(memory.at({1, 2, 3.25}).before.empty()) << "somewhere else";
}

TEST(TurbidMemory, AChangeCountsOnTheWayToTheLightOnly) {
  // up is y; a and b are x and z
  EXPECT_TRUE(isTraced(kPlace, kUp, {20, 20, 35}));
  EXPECT_TRUE(isTraced(kPlace, kUp, {20, 21, 35})) << "a gradient sees the neighbour";
  EXPECT_FALSE(isTraced(kPlace, kUp, {20, 20, 5})) << "below";
  EXPECT_FALSE(isTraced(kPlace, kUp, {20, 24, 35})) << "beside";
  EXPECT_TRUE(isTraced(kPlace, kAside, {29, 20, 32}));
  EXPECT_FALSE(isTraced(kPlace, kAside, {11, 20, 32}));
  // only the direction that meets it
  Remembering memory({kPlace}, {{0, 1, 0}, {0.6, 0.8, 0}}, VoxelField::Voxel{29, 20, 32});
  EXPECT_FALSE(TurbidMemory::isTouched(memory.at(kPlace), 0));
  EXPECT_TRUE(TurbidMemory::isTouched(memory.at(kPlace), 1));
}

TEST(TurbidMemory, EveryRayThatMeetsAChangedVoxelIsTraced) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> along(0.0, 12.0);
  std::uniform_real_distribution<double> slope(-1.0, 1.0);
  std::uniform_int_distribution<std::int64_t> cell(0, 11);
  int met = 0;
  int traced = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const VoxelField::Shape shape{{0, 0, 0}, {12, 12, 12}, 1.0, trial % 2 == 0};
    const Vec3 place{along(random), along(random), along(random)};
    const std::vector<Vec3> direction{core::normalised({slope(random), 0.6, slope(random)})};
    const VoxelField::Voxel changed{cell(random), cell(random), cell(random)};
    VoxelField field(shape, GridAxes{});
    field.values()[*field.indexOf(changed)] = 1.0;
    bool isMet = false;
    for (const Vec3& aside :
         {Vec3{}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, -1}}) {
      isMet = isMet || field.integralAlong(place + aside, direction[0]) > 0.0;
    }
    const bool isTracedAgain = isTraced(place, direction, changed, shape);
    EXPECT_TRUE(isTracedAgain || !isMet) << trial;
    met += isMet ? 1 : 0;
    traced += isTracedAgain ? 1 : 0;
  }
  // and not many more: seven rays are as wide as five voxels, the tube around them as wide as five by five with corners
  EXPECT_GT(met, 50);
  EXPECT_LT(traced, 8 * met);
}

TEST(TurbidMemory, InABoxThatRepeatsItselfAChangeIsEverywhereAround) {
  VoxelField::Shape stand = kShape;
  stand.isPeriodic = true;
  const std::vector<Vec3> flat{core::normalised({0.995, 0.0998, 0})};
  // the ray comes back from the other side: at x = 5.5 + 40 it is 2.5 higher
  EXPECT_TRUE(isTraced(kPlace, flat, {5, 20, 23}, stand));
  EXPECT_FALSE(isTraced(kPlace, flat, {5, 20, 23}));
  // a direction that is nearly level is everywhere
  const std::vector<Vec3> level{core::normalised({1, 1e-5, 0})};
  EXPECT_TRUE(isTraced(kPlace, level, {5, 5, 39}, stand));
}

TEST(TurbidMemory, BesideTheBoxAllIsTracedAfterAChange) {
  const Vec3 beside{-0.5, 20.5, 20.5};
  EXPECT_TRUE(isTraced(beside, kUp, {30, 30, 5}));
  Remembering memory({beside}, kUp, std::nullopt);
  EXPECT_FALSE(TurbidMemory::isTouched(memory.at(beside), 0)) << "nothing changed";
}

TEST(TurbidMemory, APlaceThatIsNoNumberIsNotKept) {
  const Vec3 nowhere{std::numeric_limits<double>::quiet_NaN(), 0, 0};
  Remembering memory({nowhere, kPlace}, kUp, std::nullopt);
  EXPECT_EQ(memory.at(nowhere).parts.size(), 3U);
  EXPECT_TRUE(memory.at(nowhere).before.empty());
  EXPECT_FALSE(memory.at(kPlace).before.empty());
}

TEST(TurbidMemory, WhenMuchChangedNothingIsKnown) {
  VoxelField field(kShape, GridAxes{});
  TurbidMemory memory;
  memory.begin(field, kShape, kUp);
  for (int i = 0; i < 8; ++i) {
    static_cast<void>(memory.lookAt(kPlace, 3));
  }
  std::fill_n(field.values().begin(), 3, 1.0);
  memory.begin(field, kShape, kUp);
  EXPECT_TRUE(memory.lookAt(kPlace, 3).before.empty());
}

}  // namespace
}  // namespace espalier::environment::turbid_memory_test
