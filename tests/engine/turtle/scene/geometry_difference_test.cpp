#include "engine/turtle/scene/geometry_difference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace espalier::turtle::geometry_difference_test {
namespace {

void addSource(GeometrySources& sources, std::uint32_t plant, std::uint64_t module) {
  sources.plant.push_back(plant);
  sources.module.push_back(module);
  sources.symbol.push_back(2);
  sources.colour.push_back(7);
  sources.branchOrder.push_back(1);
}

/// A segment from (x, 0, 0), drawn by that module.
void addSegment(Geometry& geometry, double x, std::uint64_t module) {
  addSource(geometry.segments, 0, module);
  geometry.start.push_back({x, 0.0, 0.0});
  geometry.end.push_back({x, 1.0, 0.0});
  geometry.startWidth.push_back(0.1);
  geometry.endWidth.push_back(0.1);
}

/// A triangle, or two, at (x, 0, 0).
void addOrgan(Geometry& geometry, double x, std::uint64_t module, bool isSquare = false) {
  addSource(geometry.organs, 0, module);
  geometry.kind.push_back(GeometryKind::Polygon);
  const auto first = static_cast<std::uint32_t>(geometry.vertices.size());
  for (const core::Vec3& corner : {core::Vec3{0, 0, 0}, core::Vec3{1, 0, 0}, core::Vec3{1, 1, 0}}) {
    geometry.vertices.push_back(corner + core::Vec3{x, 0, 0});
  }
  geometry.triangles.push_back({first, first + 1, first + 2});
  if (isSquare) {
    geometry.vertices.push_back({x, 1, 0});
    geometry.triangles.push_back({first, first + 2, first + 3});
  }
  geometry.vertexOffset.push_back(geometry.vertices.size());
  geometry.triangleOffset.push_back(geometry.triangles.size());
}

TEST(GeometryDifference, WhatStayedIsARunWithTheShiftOfItsModules) {
  Geometry before;
  Geometry now;
  for (const double x : {0.0, 1.0, 2.0, 3.0}) {
    addSegment(before, x, static_cast<std::uint64_t>(x) * 10);
  }
  // a new one between the second and the third, behind which modules are 5 further on; the last is gone
  addSegment(now, 0.0, 0);
  addSegment(now, 1.0, 10);
  addSegment(now, 9.0, 15);
  addSegment(now, 2.0, 25);
  const GeometryDifference difference = differenceOf(before, now);
  EXPECT_EQ(difference.segments, (std::vector<GeometryRun>{{0, 2, 0}, {GeometryRun::kNew, 1, 0}, {2, 1, 5}}));
  EXPECT_EQ(difference.added.start, (std::vector<core::Vec3>{{9.0, 0.0, 0.0}}));
  EXPECT_TRUE(difference.organs.empty());
}

TEST(GeometryDifference, ATurnedOrganIsNew) {
  Geometry before;
  addOrgan(before, 0.0, 1);
  addOrgan(before, 5.0, 2, true);
  Geometry now;
  addOrgan(now, 0.0, 1);
  addOrgan(now, 5.5, 2, true);
  const GeometryDifference difference = differenceOf(before, now);
  EXPECT_EQ(difference.organs, (std::vector<GeometryRun>{{0, 1, 0}, {GeometryRun::kNew, 1, 0}}));
  // the new organ's triangles refer to its own vertices
  EXPECT_EQ(difference.added.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST(GeometryDifference, ApplyingADifferenceGivesTheSameBits) {
  std::mt19937 random(4);
  for (int round = 0; round < 50; ++round) {
    Geometry before;
    Geometry now;
    std::uint64_t module = 0;
    for (int i = 0; i < 60; ++i) {
      // repeated looks, rows that go, come and change places
      const double x = static_cast<double>(random() % 7) - 3.0;
      const bool isSquare = random() % 2 == 0;
      module += random() % 4;
      if (random() % 3 != 0) {
        addSegment(before, x, module);
        addOrgan(before, x, module, isSquare);
      }
      if (random() % 3 != 0) {
        addSegment(now, x == 0.0 ? -0.0 : x, module + 9);
        addOrgan(now, x + (random() % 5 == 0 ? 0.5 : 0.0), module + 9, isSquare);
      }
    }
    now.areWidthsPixels = round % 2 == 0;
    Geometry made;
    EXPECT_EQ(applyDifference(before, differenceOf(before, now), made), std::nullopt);
    EXPECT_EQ(made, now);
    for (std::size_t i = 0; i < now.start.size(); ++i) {
      EXPECT_EQ(std::signbit(made.start[i].x), std::signbit(now.start[i].x));
    }
  }
}

TEST(GeometryDifference, RowsComeGoAndMoveFarAndNear) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    std::vector<double> rows;
    for (int i = 0; i < 400; ++i) {
      rows.push_back(i);
    }
    const auto geometryOf = [&rows] {
      Geometry geometry;
      for (const double x : rows) {
        addSegment(geometry, x, static_cast<std::uint64_t>(x));
        addOrgan(geometry, x, static_cast<std::uint64_t>(x), static_cast<int>(x) % 3 == 0);
      }
      return geometry;
    };
    const Geometry before = geometryOf();
    std::size_t changed = 0;
    for (std::size_t edits = random() % 4; edits > 0; --edits) {
      const auto at = [&rows](std::size_t place) { return rows.begin() + static_cast<std::ptrdiff_t>(place); };
      const std::size_t place = random() % rows.size();
      const std::size_t count = 1 + random() % (random() % 2 == 0 ? 5 : 150);
      const std::size_t end = std::min(rows.size(), place + count);
      switch (random() % 3) {
        case 0:
          rows.insert(at(place), count, 1000.0 + static_cast<double>(random() % 3));
          changed += count;
          break;
        case 1:
          rows.erase(at(place), at(end));
          break;
        default: {
          const std::vector<double> moved(at(place), at(end));
          rows.erase(at(place), at(end));
          const std::size_t target = random() % (rows.size() + 1);
          rows.insert(at(target), moved.begin(), moved.end());
          // either these or those between are new when it is not far
          changed += 2 * 64;
        }
      }
    }
    const Geometry now = geometryOf();
    const GeometryDifference difference = differenceOf(before, now);
    Geometry made;
    EXPECT_EQ(applyDifference(before, difference, made), std::nullopt);
    EXPECT_EQ(made, now);
    EXPECT_LE(difference.added.start.size(), changed) << "round " << round;
  }
}

TEST(GeometryDifference, NothingChangedIsOneRunATable) {
  Geometry geometry;
  for (int i = 0; i < 5; ++i) {
    addSegment(geometry, 1.0, 3);
    addOrgan(geometry, 1.0, 3);
  }
  const GeometryDifference difference = differenceOf(geometry, geometry);
  EXPECT_EQ(difference.segments, (std::vector<GeometryRun>{{0, 5, 0}}));
  EXPECT_EQ(difference.organs, (std::vector<GeometryRun>{{0, 5, 0}}));
}

TEST(GeometryDifference, ADifferenceOfAnotherGeometryIsRefused) {
  Geometry before;
  addSegment(before, 0.0, 0);
  addSegment(before, 1.0, 1);
  Geometry now;
  GeometryDifference difference;
  difference.segments = {{1, 2, 0}};
  EXPECT_EQ(applyDifference(before, difference, now),
            "a run of segments takes rows 1 to 3 of those before, of which there are 2");
  difference.segments = {{GeometryRun::kNew, 1, 0}};
  EXPECT_EQ(applyDifference(before, difference, now),
            "a run of segments takes rows 0 to 1 of the new ones, of which there are 0");
  difference.segments = {{0, 2, 0}, {0, 1, 0}};
  EXPECT_EQ(applyDifference(before, difference, now),
            "the runs of segments take more rows than the 2 before and the 0 new ones");
  difference.segments = {{0, 2, 0}};
  addOrgan(difference.added, 0.0, 0);
  EXPECT_EQ(applyDifference(before, difference, now), "the runs of organs take 0 new rows, but 1 came");
}

}  // namespace
}  // namespace espalier::turtle::geometry_difference_test
