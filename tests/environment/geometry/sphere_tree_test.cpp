#include "environment/geometry/sphere_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace espalier::environment::sphere_tree_test {
namespace {

using core::Vec3;

std::vector<Sphere> manySpheres(std::size_t count) {
  std::mt19937_64 random(10);
  std::uniform_real_distribution<double> place(-10, 10);
  std::uniform_real_distribution<double> radius(0, 0.6);
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    spheres.push_back({{place(random), place(random), place(random)}, radius(random)});
  }
  return spheres;
}

// whether a ray comes within a sphere's radius and a margin
bool meets(const Ray& ray, const Sphere& sphere, double margin) {
  const Vec3 between = sphere.centre - ray.origin;
  const double along = std::clamp(core::dot(between, ray.direction), 0.0, ray.reach);
  return core::length(between - ray.direction * along) <= sphere.radius + margin;
}

TEST(DistinctSpheres, EqualOnesAreOneAndAreCounted) {
  const Sphere a{{1, 0, 0}, 2};
  const Sphere b{{1, 0, 0}, 3};
  const Sphere c{{0, 5, 0}, 1};
  const DistinctSpheres distinct = distinctSpheres({b, a, c, a, a});
  ASSERT_EQ(distinct.spheres.size(), 3U);
  EXPECT_EQ(distinct.spheres[0].centre, c.centre);
  EXPECT_EQ(distinct.spheres[1].radius, 2.0);
  EXPECT_EQ(distinct.count, (std::vector<std::uint32_t>{1, 3, 1}));
  EXPECT_EQ(distinct.indexOf, (std::vector<std::uint32_t>{2, 1, 0, 1, 1}));
}

TEST(SphereTree, FindsEverySphereOnARay) {
  const auto spheres = distinctSpheres(manySpheres(3000)).spheres;
  const SphereTree tree(spheres);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-12, 12);
  std::size_t met = 0;
  std::size_t visited = 0;
  for (int round = 0; round < 300; ++round) {
    // along an axis too, where a component of the direction is 0
    const Vec3 direction = round % 3 == 0 ? Vec3{0, round % 2 == 0 ? 1.0 : -1.0, 0}
                                          : core::normalised(Vec3{place(random), place(random), place(random)});
    const Ray ray{{place(random), place(random), place(random)}, direction, 8.0};
    std::set<std::uint32_t> found;
    tree.visitRay(ray, 0.25, [&](std::uint32_t index, const Sphere& sphere) {
      EXPECT_EQ(sphere.centre, spheres[index].centre);
      EXPECT_TRUE(found.insert(index).second);
      return true;
    });
    visited += found.size();
    for (std::uint32_t i = 0; i < spheres.size(); ++i) {
      if (meets(ray, spheres[i], 0.25)) {
        ++met;
        EXPECT_TRUE(found.contains(i)) << round;
      }
    }
  }
  EXPECT_GT(met, 500U);
  // boxes of four neighbours are not much larger than a sphere
  EXPECT_LT(visited, 20 * met);
}

TEST(SphereTree, AVisitorCanStop) {
  const SphereTree tree(std::vector<Sphere>(20, Sphere{{0, 5, 0}, 1}));
  int visits = 0;
  tree.visitRay({{0, 0, 0}, {0, 1, 0}, 100}, 0.0, [&](std::uint32_t, const Sphere&) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(SphereTree, SpheresWithoutARadiusAreFoundWithAMargin) {
  const SphereTree points({Sphere{{0, 5, 0}, 0}, Sphere{{1, 5, 0}, 0}});
  std::vector<std::uint32_t> met;
  points.visitRay({{0.02, 0, 0}, {0, 1, 0}, 100}, 0.1, [&](std::uint32_t index, const Sphere& sphere) {
    if (sphere.centre.x == 0.0) {
      met.push_back(index);
    }
    return true;
  });
  EXPECT_EQ(met, std::vector<std::uint32_t>{0});
}

TEST(SphereTree, WithoutSpheresNothingIsVisited) {
  const SphereTree none({});
  none.visitRay({{0, 0, 0}, {0, 1, 0}, 100}, 0.0, [&](std::uint32_t, const Sphere&) {
    ADD_FAILURE();
    return true;
  });
  EXPECT_TRUE(none.order().empty());
}

TEST(SphereTree, TheOrderHasEverySphereOnce) {
  const auto spheres = manySpheres(1000);
  std::vector<std::uint32_t> order = SphereTree(spheres).order();
  std::sort(order.begin(), order.end());
  for (std::uint32_t i = 0; i < spheres.size(); ++i) {
    EXPECT_EQ(order[i], i);
  }
}

}  // namespace
}  // namespace espalier::environment::sphere_tree_test
