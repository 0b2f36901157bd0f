#include "environment/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace espalier::environment::box_tree_test {
namespace {

using core::Vec3;

std::vector<Bounds> manyBoxes(std::size_t count) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-10, 10);
  std::uniform_real_distribution<double> side(0, 1.5);
  std::vector<Bounds> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 low{place(random), place(random), place(random)};
    boxes.push_back({low, low + Vec3{side(random), side(random), side(random)}});
  }
  return boxes;
}

double distanceTo(const Bounds& box, const Vec3& p) {
  const auto beyond = [](double low, double high, double value) { return std::max({low - value, value - high, 0.0}); };
  return core::length(
      {beyond(box.low.x, box.high.x, p.x), beyond(box.low.y, box.high.y, p.y), beyond(box.low.z, box.high.z, p.z)});
}

TEST(BoxTree, VisitsEveryBoxWithinTheRadiusAndFewOthers) {
  const auto boxes = manyBoxes(2000);
  const BoxTree tree(boxes);
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> place(-11, 11);
  for (int round = 0; round < 100; ++round) {
    const Vec3 point{place(random), place(random), place(random)};
    std::set<unsigned> visited;
    tree.visitNear(point, 2.0, [&](unsigned index) {
      EXPECT_TRUE(visited.insert(index).second) << "twice: " << index;
      return 2.0;
    });
    for (unsigned i = 0; i < boxes.size(); ++i) {
      const double distance = distanceTo(boxes[i], point);
      EXPECT_TRUE(distance > 2.0 || visited.contains(i));
      // the boxes are widened by no more than single precision needs
      EXPECT_TRUE(distance < 2.01 || !visited.contains(i));
    }
  }
}

TEST(BoxTree, ASmallerRadiusLeavesOutWhatIsFurther) {
  const auto boxes = manyBoxes(2000);
  const BoxTree tree(boxes);
  const Vec3 point{1, 2, 3};
  double nearest = 100.0;
  std::size_t visits = 0;
  tree.visitNear(point, nearest, [&](unsigned index) {
    ++visits;
    nearest = std::min(nearest, distanceTo(boxes[index], point));
    return nearest;
  });
  double expected = 100.0;
  for (const Bounds& box : boxes) {
    expected = std::min(expected, distanceTo(box, point));
  }
  EXPECT_EQ(nearest, expected);
  EXPECT_LT(visits, boxes.size() / 4);
}

TEST(BoxTree, VisitsEveryBoxOnARay) {
  const auto boxes = manyBoxes(2000);
  const BoxTree tree(boxes);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-11, 11);
  std::size_t met = 0;
  for (int round = 0; round < 30; ++round) {
    const Vec3 origin{place(random), place(random), place(random)};
    const Vec3 direction = core::normalised(Vec3{place(random), place(random), place(random)});
    std::set<unsigned> visited;
    tree.visitRay(origin, direction, 15.0, [&](unsigned index) {
      visited.insert(index);
      return 15.0;
    });
    // points of the ray, and the boxes that they are in
    for (double t = 0.0; t <= 15.0; t += 0.05) {
      const Vec3 point = origin + direction * t;
      for (unsigned i = 0; i < boxes.size(); ++i) {
        if (distanceTo(boxes[i], point) == 0.0) {
          ++met;
          EXPECT_TRUE(visited.contains(i));
        }
      }
    }
  }
  EXPECT_GT(met, 20U);
}

TEST(BoxTree, FarFromTheOriginNothingIsLostToSinglePrecision) {
  // a unit box 10⁷ away, where floats are a unit apart
  const std::vector<Bounds> boxes{{{1e7, 1e7, 0}, {1e7 + 1, 1e7 + 1, 1}}};
  const BoxTree tree(boxes);
  int visits = 0;
  tree.visitNear({1e7 + 1.5, 1e7, 0.5}, 0.6, [&](unsigned) {
    ++visits;
    return 0.6;
  });
  EXPECT_EQ(visits, 1);
  tree.visitRay({1e7 + 0.5, 1e7 + 20, 0.5}, {0, -1, 0}, 19.5, [&](unsigned) {
    ++visits;
    return 19.5;
  });
  EXPECT_EQ(visits, 2);
}

TEST(BoxTree, WithoutBoxesNothingIsVisited) {
  const BoxTree tree(std::vector<Bounds>{});
  tree.visitNear({0, 0, 0}, 10.0, [](unsigned) {
    ADD_FAILURE();
    return 0.0;
  });
  tree.visitRay({0, 0, 0}, {1, 0, 0}, 10.0, [](unsigned) {
    ADD_FAILURE();
    return 0.0;
  });
}

}  // namespace
}  // namespace espalier::environment::box_tree_test
