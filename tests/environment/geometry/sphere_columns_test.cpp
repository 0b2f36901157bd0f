#include "environment/geometry/sphere_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace espalier::environment::sphere_columns_test {
namespace {

using core::Vec3;

std::vector<Sphere> manySpheres(std::size_t count, double smallest, double largest) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> place(-10, 10);
  std::uniform_real_distribution<double> radius(smallest, largest);
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    spheres.push_back({{place(random), place(random), place(random)}, radius(random)});
  }
  return spheres;
}

/// How far a sphere's middle is from the line through a place.
double distanceFrom(const Vec3& place, const Vec3& direction, const Sphere& sphere) {
  const Vec3 between = sphere.centre - place;
  return core::length(between - direction * core::dot(between, direction));
}

/// The spheres that the columns find there, ascending.
std::vector<std::uint32_t> foundAt(const SphereColumns& columns, const Vec3& place) {
  std::vector<std::uint32_t> found;
  columns.visit(place, [&](std::uint32_t index, const Sphere&) {
    found.push_back(index);
    return true;
  });
  EXPECT_TRUE(std::ranges::is_sorted(found));
  EXPECT_EQ(std::ranges::adjacent_find(found), found.end());
  return found;
}

void expectAllFound(const std::vector<Sphere>& spheres, const Vec3& direction, double margin) {
  const SphereColumns columns(spheres, direction, margin);
  ASSERT_TRUE(columns.isMade());
  for (const Sphere& own : spheres) {
    const std::vector<std::uint32_t> found = foundAt(columns, own.centre);
    for (std::uint32_t index = 0; index < spheres.size(); ++index) {
      if (distanceFrom(own.centre, direction, spheres[index]) <= spheres[index].radius + margin) {
        EXPECT_TRUE(std::ranges::binary_search(found, index)) << index;
      }
    }
  }
}

TEST(SphereColumns, FindEverySphereOnALine) {
  const std::vector<Sphere> spheres = manySpheres(400, 0.0, 0.9);
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> component(-1, 1);
  for (int round = 0; round < 12; ++round) {
    // along the axes, too
    const Vec3 direction = round < 3 ? Vec3{round == 0 ? 1.0 : 0.0, round == 1 ? -1.0 : 0.0, round == 2 ? 1.0 : 0.0}
                                     : core::normalised(Vec3{component(random), component(random), component(random)});
    expectAllFound(spheres, direction, round % 2 == 0 ? 0.0 : 0.3);
  }
}

TEST(SphereColumns, SpheresThatTouchALineAreFoundAtTheRimsOfCells) {
  // radius and distance are the same number, at whole places
  std::vector<Sphere> spheres;
  for (int x = 0; x < 12; ++x) {
    for (int z = 0; z < 12; ++z) {
      spheres.push_back({{1.0 * x, 0.5 * z, 1.0 * z}, 1.0});
    }
  }
  expectAllFound(spheres, {0, 1, 0}, 0.0);
  expectAllFound(spheres, {0, 0, 1}, 0.0);
}

TEST(SphereColumns, PointsOfALineAndOfOnePlaceAreFound) {
  std::vector<Sphere> line;
  for (int i = 0; i < 300; ++i) {
    line.push_back({{0, 0.1 * i, 0}, 0.0});
  }
  expectAllFound(line, {0, 0, 1}, 0.0);
  expectAllFound(line, {0, 1, 0}, 0.0);
  expectAllFound({{{3, 4, 5}, 0.0}}, {0, 1, 0}, 0.0);
}

TEST(SphereColumns, FewOfManySpheresAreLookedAt) {
  const std::vector<Sphere> spheres = manySpheres(4000, 0.1, 0.3);
  const SphereColumns columns(spheres, {0, 1, 0}, 0.0);
  std::size_t looked = 0;
  for (const Sphere& own : spheres) {
    looked += foundAt(columns, own.centre).size();
  }
  // a disc of radius 0.2 among 400: 1.3 of 4000 spheres are met by a line
  EXPECT_LT(looked, 12 * spheres.size());
}

TEST(SphereColumns, AVisitorCanStop) {
  const std::vector<Sphere> spheres(20, Sphere{{0, 5, 0}, 1});
  int visits = 0;
  SphereColumns(spheres, {0, 1, 0}, 0.0).visit({0, 0, 0}, [&](std::uint32_t, const Sphere&) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(SphereColumns, BesideAllSpheresNothingIsFound) {
  const std::vector<Sphere> spheres = manySpheres(50, 0.1, 0.3);
  const SphereColumns columns(spheres, {0, 1, 0}, 0.0);
  EXPECT_TRUE(foundAt(columns, {50, 0, 0}).empty());
  EXPECT_TRUE(foundAt(columns, {0, 0, -50}).empty());
  EXPECT_TRUE(foundAt(columns, {std::nan(""), 0, 0}).empty());
}

TEST(SphereColumns, AreNotMadeWhenTheyWouldBeTooLarge) {
  EXPECT_FALSE(SphereColumns({}, {0, 1, 0}, 0.0).isMade());
  // places that are no numbers, or too far
  EXPECT_FALSE(SphereColumns(std::vector<Sphere>{{{std::nan(""), 0, 0}, 1}}, {0, 1, 0}, 0.0).isMade());
  EXPECT_FALSE(SphereColumns(std::vector<Sphere>{{{HUGE_VAL, 0, 0}, 1}}, {0, 1, 0}, 0.0).isMade());
  EXPECT_FALSE(SphereColumns(std::vector<Sphere>{{{1e300, 0, 0}, 1}, {{0, 0, 0}, 1}}, {0, 1, 0}, 0.0).isMade());
  EXPECT_FALSE(SphereColumns(std::vector<Sphere>{{{0, 0, 0}, HUGE_VAL}}, {0, 1, 0}, 0.0).isMade());
  // a few cover everything, the others are points
  std::vector<Sphere> spheres = manySpheres(2000, 0.0, 0.0);
  for (std::size_t i = 0; i < 100; ++i) {
    spheres[i].radius = 20;
  }
  EXPECT_FALSE(SphereColumns(spheres, {0, 1, 0}, 0.0).isMade());
}

}  // namespace
}  // namespace espalier::environment::sphere_columns_test
