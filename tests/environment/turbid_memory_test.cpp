#include "environment/light/turbid_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace espalier::environment {
namespace {

using core::Vec3;

const VoxelField::Shape kShape{{0, 0, 0}, {40, 40, 40}, 1.0, false};

/// A memory that has told (20.5, 20.5, 20.5) the numbers 1 to 3, and then saw this voxel change.
TurbidMemory after(const std::optional<VoxelField::Voxel>& changed, VoxelField::Shape shape = kShape) {
  const GridAxes axes;
  VoxelField field(shape, axes);
  TurbidMemory memory;
  memory.begin(field, shape, axes);
  memory.keep({{20.5, 20.5, 20.5}, 3, {1, 2, 3, 0, 0}});
  if (changed) {
    field.values()[*field.indexOf(*changed)] = 7.0;
  }
  memory.begin(field, shape, axes);
  return memory;
}

TEST(TurbidMemory, WhatDidNotChangeIsToldAgain) {
  const std::vector<Vec3> up{{0, 1, 0}};
  const TurbidMemory memory = after(std::nullopt);
  ASSERT_NE(memory.find({20.5, 20.5, 20.5}, 3, up), nullptr);
  EXPECT_EQ(memory.find({20.5, 20.5, 20.5}, 2, up)->values[1], 2.0);
  EXPECT_EQ(memory.find({20.5, 20.5, 20.5}, 4, up), nullptr) << "more than is known";
  EXPECT_EQ(memory.find({20.5, 20.5, 20.25}, 1, up), nullptr) << "somewhere else";
}

TEST(TurbidMemory, AChangeCountsOnTheWayToTheLightOnly) {
  // up is y; a and b are x and z
  const Vec3 place{20.5, 20.5, 20.5};
  const std::vector<Vec3> up{{0, 1, 0}};
  const std::vector<Vec3> aside{{0.6, 0.8, 0}};
  EXPECT_EQ(after(VoxelField::Voxel{20, 20, 35}).find(place, 1, up), nullptr);
  EXPECT_EQ(after(VoxelField::Voxel{20, 21, 35}).find(place, 1, up), nullptr) << "a gradient sees the neighbour";
  EXPECT_NE(after(VoxelField::Voxel{20, 20, 5}).find(place, 1, up), nullptr) << "below";
  EXPECT_NE(after(VoxelField::Voxel{35, 35, 35}).find(place, 1, up), nullptr);
  EXPECT_EQ(after(VoxelField::Voxel{29, 20, 32}).find(place, 1, aside), nullptr);
  EXPECT_NE(after(VoxelField::Voxel{5, 20, 32}).find(place, 1, aside), nullptr);
}

TEST(TurbidMemory, InABoxThatRepeatsItselfAChangeIsEverywhereAround) {
  VoxelField::Shape stand = kShape;
  stand.isPeriodic = true;
  const std::vector<Vec3> flat{{0.995, 0.0998, 0}};
  // the ray comes back from the other side: at x = 5.5 + 40 it is 2.5 higher
  EXPECT_EQ(after(VoxelField::Voxel{5, 20, 23}, stand).find({20.5, 20.5, 20.5}, 1, flat), nullptr);
  EXPECT_NE(after(VoxelField::Voxel{5, 20, 23}).find({20.5, 20.5, 20.5}, 1, flat), nullptr);
}

TEST(TurbidMemory, AGradientJustOutsideTheBoxSeesIntoIt) {
  const std::vector<Vec3> up{{0, 1, 0}};
  for (const Vec3& place : {Vec3{-0.5, 20.5, 20.5}, Vec3{40.5, 20.5, 20.5}, Vec3{20.5, 40.5, 20.5}}) {
    const GridAxes axes;
    VoxelField field(kShape, axes);
    TurbidMemory memory;
    memory.begin(field, kShape, axes);
    memory.keep({place, 5, {}});
    // a and b are x and z, the layer is y
    const auto within = [](double along) { return static_cast<std::int64_t>(std::clamp(along, 0.0, 39.5)); };
    field.values()[*field.indexOf({within(place.x), within(place.z), 39})] = 7.0;
    memory.begin(field, kShape, axes);
    EXPECT_EQ(memory.find(place, 5, up), nullptr) << place.x << " " << place.y;
  }
}

TEST(TurbidMemory, APlaceThatIsNoNumberIsNotKept) {
  const GridAxes axes;
  VoxelField field(kShape, axes);
  TurbidMemory memory;
  memory.begin(field, kShape, axes);
  const Vec3 nowhere{std::numeric_limits<double>::quiet_NaN(), 0, 0};
  memory.keep({nowhere, 5, {}});
  memory.keep({{1, 2, 3}, 5, {}});
  memory.begin(field, kShape, axes);
  EXPECT_EQ(memory.find(nowhere, 1, std::vector<Vec3>{{0, 1, 0}}), nullptr);
  EXPECT_NE(memory.find({1, 2, 3}, 1, std::vector<Vec3>{{0, 1, 0}}), nullptr);
}

TEST(TurbidMemory, WhenMuchChangedNothingIsKnown) {
  const GridAxes axes;
  VoxelField field(kShape, axes);
  TurbidMemory memory;
  memory.begin(field, kShape, axes);
  memory.keep({{20.5, 20.5, 20.5}, 3, {1, 2, 3, 0, 0}});
  std::fill(field.values().begin(), field.values().begin() + 20'000, 1.0);
  memory.begin(field, kShape, axes);
  EXPECT_EQ(memory.find({20.5, 20.5, 20.5}, 1, std::vector<Vec3>{{0, 1, 0}}), nullptr);
}

}  // namespace
}  // namespace espalier::environment
