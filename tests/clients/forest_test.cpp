// The parts of `espalier forest`: trees as points, their colours, and where they stand.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/forest/layout.h"
#include "clients/espalier/forest/tree_painting.h"
#include "clients/espalier/forest/tree_points.h"
#include "engine/core/elementary.h"
#include "engine/core/random.h"

namespace espalier::command::forest_test {
namespace {

turtle::Segment line(const core::Vec3& start, const core::Vec3& end, std::uint32_t order, std::uint32_t parent) {
  turtle::Segment segment;
  segment.start = start;
  segment.end = end;
  segment.branchOrder = order;
  segment.parent = parent;
  return segment;
}

// F[+F]FF
turtle::Scene forkedTree() {
  turtle::Scene scene;
  scene.segments = {line({0, 0, 0}, {0, 1, 0}, 0, turtle::kNoParent), line({0, 1, 0}, {1, 1.5, 0}, 1, 0),
                    line({0, 1, 0}, {0, 2, 0}, 0, 0), line({0, 2, 0}, {0, 3, 0}, 0, 2)};
  return scene;
}

TEST(TreePoints, CountLinesToTheFarthestLeafAndBranchesFromTheRoot) {
  const TreePoints tree = treePointsOf(forkedTree());
  std::vector<std::pair<std::uint32_t, std::uint32_t>> counts;
  for (const TreePoint& point : tree.points) {
    counts.emplace_back(point.hopsToLeaf, point.branches);
  }
  // trunk 3 lines to its tip, 2 from its end; the branch is a leaf; the last line of the trunk too
  EXPECT_EQ(counts, (std::vector<std::pair<std::uint32_t, std::uint32_t>>{
                        {3, 0}, {2, 0}, {1, 1}, {0, 1}, {2, 0}, {1, 0}, {1, 0}, {0, 0}}));
  EXPECT_DOUBLE_EQ(tree.height(), 3.0);
  EXPECT_DOUBLE_EQ(tree.radius(), 1.0);
}

TEST(TreePoints, AreWrittenAndReadBack) {
  const TreePoints tree = treePointsOf(forkedTree());
  const std::string text = writeTreePoints(tree);
  EXPECT_EQ(text.substr(0, 20), "0 0 0 3 0\n0 1 0 2 0\n");
  const auto read = readTreePoints(text);
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(writeTreePoints(*read), text);
  // other separators are possible
  EXPECT_TRUE(readTreePoints("0,0,0,1,0\r\n\n0;1;0.5;0;0\r\n"));
}

TEST(TreePoints, SayWhichLineIsWrong) {
  const auto problem = [](const char* text) {
    const Result<TreePoints> read = readTreePoints(text);
    return read ? std::string() : read.error();
  };
  EXPECT_EQ(problem("0 0 0 1 0\n0 1 x 0 0\n"), "line 2: 'x' is not a number");
  EXPECT_EQ(problem("0 0 0\n"),
            "line 1: a point is five numbers: x y z, greatest distance to a leaf, branches to the root; found 3");
  EXPECT_EQ(problem("0 0 0 1.5 0\n"),
            "line 1: the distance to a leaf and the branches to the root are whole numbers from 0");
  EXPECT_EQ(problem("0 0 0 1 0\n"),
            "the file holds 1 points; their number must be even, because two points are a line");
  EXPECT_EQ(problem("\n"), "the file holds no points");
}

TEST(TreePainting, WoodIsBrownAndLeavesAreGreen) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ForestColours colours(seed);
    const auto colourOf = [&](std::int32_t index) { return colours.palette().colour(index); };
    for (int i = 0; i < ForestColours::kTrunkShades; ++i) {
      for (const std::int32_t wood : {ForestColours::trunk(i), ForestColours::branch(i)}) {
        EXPECT_GT(colourOf(wood).red, colourOf(wood).green);
        EXPECT_GT(colourOf(wood).green, colourOf(wood).blue);
        EXPECT_LT(colourOf(wood).red, 2 * colourOf(wood).green) << "brown, not orange";
      }
    }
    for (int i = 0; i < ForestColours::kLeafShades; ++i) {
      const files::PaletteColour leaf = colourOf(ForestColours::leaf(i));
      EXPECT_GT(leaf.green, leaf.red);
      EXPECT_GT(leaf.red, leaf.blue / 2);
      EXPECT_GT(leaf.green, leaf.blue + 20);
    }
  }
}

TEST(TreePainting, ABranchWithoutATurnIsNotDrawnInsideItsTrunk) {
  TreePoints tree;
  const auto add = [&](const core::Vec3& start, const core::Vec3& end, std::uint32_t hops, std::uint32_t branches) {
    tree.points.push_back({start, hops, branches});
    tree.points.push_back({end, hops - 1, branches});
  };
  add({0, 0, 0}, {0, 2, 0}, 4, 0);
  add({0, 0, 0}, {0, 2, 0}, 3, 1);  // the same line once more
  add({0, 0, 0}, {0, 1, 0}, 3, 1);  // a part of it
  add({0, 0, 0}, {1, 1, 0}, 3, 1);
  add({0, 2, 0}, {0, 3, 0}, 3, 0);
  const turtle::Scene scene = paintTree(tree, 1, 0);
  ASSERT_EQ(scene.segments.size(), 2U);
  EXPECT_EQ(scene.segments[0].end, (core::Vec3{0, 3, 0}));
  EXPECT_EQ(scene.segments[1].end, (core::Vec3{1, 1, 0}));
  // one that goes beyond the line of its trunk is drawn
  add({1, 1, 0}, {3, 3, 0}, 2, 2);
  add({0, 0, 0}, {2, 2, 0}, 3, 1);
  const turtle::Scene beyond = paintTree(tree, 1, 0);
  ASSERT_EQ(beyond.segments.size(), 4U);
  EXPECT_EQ(beyond.segments[3].end, (core::Vec3{2, 2, 0}));
}

TEST(TreePainting, SomeLeavesAreFlowersOfOneGroup) {
  // a comb: 4000 leaves on a trunk
  TreePoints tree;
  for (int i = 0; i < 4000; ++i) {
    const double y = i;
    tree.points.push_back({{0, y, 0}, 4000U - static_cast<std::uint32_t>(i), 0});
    tree.points.push_back({{0, y + 1, 0}, 3999U - static_cast<std::uint32_t>(i) + 1U, 0});
    tree.points.push_back({{0, y, 0}, 1, 1});
    tree.points.push_back({{1, y, 0}, 0, 1});
  }
  const turtle::Scene scene = paintTree(tree, 1, 0);
  ASSERT_EQ(scene.polygons.size(), 4000U);
  std::set<int> groups;
  int flowers = 0;
  for (const turtle::Polygon& leaf : scene.polygons) {
    const int beyondLeaves = leaf.colour - ForestColours::leaf(ForestColours::kLeafShades);
    if (beyondLeaves >= 0) {
      ++flowers;
      groups.insert(beyondLeaves / (2 * ForestColours::kFlowerShades));
    }
  }
  // 4000 draws of probability 0.08: 320, standard deviation 17.2; four of them
  EXPECT_NEAR(flowers, 320, 69);
  EXPECT_EQ(groups.size(), 1U);
}

TEST(TreePainting, WhatGoesOnStraightIsOneLineThatGetsThinner) {
  // a trunk of four lines with a branch of two at half its height, each ending in a leaf
  TreePoints tree;
  const auto add = [&](const core::Vec3& start, const core::Vec3& end, std::uint32_t hops, std::uint32_t branches) {
    tree.points.push_back({start, hops, branches});
    tree.points.push_back({end, hops - 1, branches});
  };
  add({0, 0, 0}, {0, 1, 0}, 5, 0);
  add({0, 1, 0}, {0, 2, 0}, 4, 0);
  add({0, 2, 0}, {1, 2, 0}, 2, 1);
  add({1, 2, 0}, {2, 2, 0}, 1, 1);
  add({0, 2, 0}, {0, 3, 0}, 3, 0);
  add({0, 3, 0}, {0, 4, 0}, 2, 0);
  add({0, 4, 0}, {0, 5, 0}, 1, 0);
  const turtle::Scene scene = paintTree(tree, 1, 0);
  ASSERT_EQ(scene.segments.size(), 2U);
  const turtle::Segment& trunk = scene.segments[0];
  const turtle::Segment& branch = scene.segments[1];
  EXPECT_EQ(trunk.end, (core::Vec3{0, 4, 0}));
  EXPECT_EQ(branch.parent, 0U);
  EXPECT_EQ(branch.end, (core::Vec3{1, 2, 0}));
  EXPECT_NE(trunk.colour, branch.colour);
  // by level and height; along the axis of five down to a quarter at its tip, four fifths on 1 - 0.75 * 0.8
  EXPECT_DOUBLE_EQ(branch.startWidth, 0.5 * trunk.startWidth);
  EXPECT_DOUBLE_EQ(trunk.endWidth, 0.4 * trunk.startWidth);
  TreePoints twice = tree;
  for (TreePoint& point : twice.points) {
    point.position = 2.0 * point.position;
  }
  EXPECT_DOUBLE_EQ(paintTree(twice, 1, 0).segments[0].startWidth, 2.0 * trunk.startWidth);
  // leaves begin where their line does and go its way
  ASSERT_EQ(scene.polygons.size(), 2U);
  EXPECT_EQ(scene.polygons[0].vertices.front(), (core::Vec3{1, 2, 0}));
  EXPECT_EQ(scene.polygons[0].vertices[2], (core::Vec3{2, 2, 0}));
  EXPECT_EQ(scene.polygons[0].parent, 1U);
  // a bend begins a line
  for (const std::size_t point : {3U, 4U, 8U}) {
    tree.points[point].position = {0.5, 2, 0};
  }
  EXPECT_EQ(paintTree(tree, 1, 0).segments.size(), 5U);
}

TEST(ForestLayout, NoTwoTreesStandInOnePlace) {
  for (const Spacing spacing : {Spacing::Grid, Spacing::Jittered, Spacing::Poisson, Spacing::Competition}) {
    const std::vector<TreePlace> places = layoutForest(spacing, 300, 2.0, 5);
    ASSERT_EQ(places.size(), 300U);
    std::set<std::pair<double, double>> roots;
    for (const TreePlace& place : places) {
      EXPECT_EQ(place.position.y, 0.0);
      roots.emplace(place.position.x, place.position.z);
    }
    EXPECT_EQ(roots.size(), 300U);
    // the same again, and another forest for another seed
    EXPECT_EQ(layoutForest(spacing, 300, 2.0, 5)[17].position, places[17].position);
    EXPECT_NE(layoutForest(spacing, 300, 2.0, 6)[17].position, places[17].position);
  }
}

double leastDistance(const std::vector<TreePlace>& places) {
  double least = INFINITY;
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      least = std::min(least, core::length(places[i].position - places[j].position));
    }
  }
  return least;
}

TEST(ForestLayout, KeepsTheDistance) {
  EXPECT_GE(leastDistance(layoutForest(Spacing::Poisson, 500, 3.0, 1)), 3.0);
  EXPECT_NEAR(leastDistance(layoutForest(Spacing::Grid, 500, 3.0, 1)), 3.0, 1e-12);
  // at most 0.4 cells off: a fifth of a cell stays between
  EXPECT_GE(leastDistance(layoutForest(Spacing::Jittered, 500, 3.0, 1)), 0.6);
}

TEST(ForestLayout, JitterHidesTheRows) {
  const auto columns = [](Spacing spacing) {
    std::set<double> found;
    for (const TreePlace& place : layoutForest(spacing, 400, 1.0, 3)) {
      found.insert(place.position.x);
    }
    return found.size();
  };
  // a disc of 600 points is about 28 columns wide
  EXPECT_LT(columns(Spacing::Grid), 32U);
  EXPECT_EQ(columns(Spacing::Jittered), 400U);
}

TEST(ForestLayout, JitterGoesToAllSides) {
  // the middle of the grid is at a point or between two
  double middle = 0.0;
  for (const TreePlace& place : layoutForest(Spacing::Grid, 400, 1.0, 3)) {
    middle = std::abs(place.position.x - std::round(place.position.x));
  }
  double sumX = 0.0;
  double sumZ = 0.0;
  for (const TreePlace& place : layoutForest(Spacing::Jittered, 400, 1.0, 3)) {
    const auto offset = [middle](double coordinate) { return coordinate - middle - std::round(coordinate - middle); };
    const double x = offset(place.position.x);
    const double z = offset(place.position.z);
    EXPECT_LE(std::max(std::abs(x), std::abs(z)), 0.4);
    sumX += x;
    sumZ += z;
  }
  // uniform in -0.4 to 0.4: the mean of 400 has the standard deviation 0.0115; four of them
  EXPECT_NEAR(sumX / 400.0, 0.0, 0.046);
  EXPECT_NEAR(sumZ / 400.0, 0.0, 0.046);
}

TEST(ForestLayout, TreesAreTurnedToAllSides) {
  for (const Spacing spacing : {Spacing::Grid, Spacing::Jittered, Spacing::Poisson, Spacing::Competition}) {
    std::array<int, 4> quarters{};
    for (const TreePlace& place : layoutForest(spacing, 400, 1.0, 3)) {
      const double quarter = place.turnRadians / (0.5 * std::numbers::pi);
      ASSERT_GE(quarter, 0.0);
      ASSERT_LT(quarter, 4.0);
      ++quarters[static_cast<std::size_t>(quarter)];
    }
    for (const int count : quarters) {
      // 400 draws of probability 1/4: 100, standard deviation 8.7; four of them
      EXPECT_NEAR(count, 100, 35) << static_cast<int>(spacing);
    }
  }
}

TEST(ForestLayout, AForestIsADisc) {
  for (const Spacing spacing : {Spacing::Grid, Spacing::Jittered, Spacing::Poisson, Spacing::Competition}) {
    int far = 0;
    for (const TreePlace& place : layoutForest(spacing, 400, 1.0, 3)) {
      // a square of the area of the least dense one, 2.2 a tree, would have corners at 21
      far += core::length(place.position) > 18.0 ? 1 : 0;
    }
    EXPECT_EQ(far, 0) << static_cast<int>(spacing);
  }
}

TEST(ForestLayout, InCompetitionNeighboursHoldEachOtherOff) {
  // 200 trees on 200 squared distances; at random the least distance would be about 1 / (2 * sqrt(200) * ...), far
  // below a tenth: discs that touched would have ended the smaller tree
  const std::vector<TreePlace> places = layoutForest(Spacing::Competition, 200, 1.0, 2);
  EXPECT_GT(leastDistance(places), 0.25);
  const auto [least, most] = std::minmax_element(
      places.begin(), places.end(), [](const TreePlace& a, const TreePlace& b) { return a.size < b.size; });
  EXPECT_DOUBLE_EQ(most->size, 1.0);
  EXPECT_GT(least->size, 0.5);  // seedlings grow at 0.7 to 1.3
  EXPECT_LT(least->size, 0.75);
}

// The seedlings that are left of a competition, one pair after the other
std::set<std::pair<double, double>> survivors(std::size_t count, std::uint64_t seed, bool* areTooFewLeft) {
  const core::CounterRandom random(seed, 0);
  std::uint64_t draw = 0;
  const auto uniform = [&] { return random.uniform(core::DrawDomain::Environment, 3, draw++, 0); };
  struct Seedling {
    core::Vec3 position;
    double growth;
    double radius;
  };
  std::vector<Seedling> alive;
  for (std::size_t i = 0; i < 4 * count; ++i) {
    const double radius = std::sqrt(static_cast<double>(count)) * std::sqrt(uniform() / std::numbers::pi);
    const double angle = 2.0 * std::numbers::pi * uniform();
    uniform();  // how it is turned
    alive.push_back({{radius * core::cos(angle), 0.0, radius * core::sin(angle)}, 0.7 + 0.6 * uniform(), 0.0});
  }
  while (alive.size() > count) {
    for (Seedling& seedling : alive) {
      seedling.radius += 0.02 * seedling.growth;
    }
    std::vector<Seedling> next;
    std::vector<Seedling> dead;
    for (const Seedling& one : alive) {
      const bool dies = std::ranges::any_of(alive, [&](const Seedling& other) {
        return other.radius > one.radius && core::length(other.position - one.position) < other.radius + one.radius;
      });
      (dies ? dead : next).push_back(one);
    }
    *areTooFewLeft = next.size() < count;
    std::ranges::stable_sort(dead, std::ranges::greater{}, &Seedling::radius);
    for (std::size_t i = 0; next.size() < count; ++i) {
      next.push_back(dead.at(i));
    }
    alive = next;
  }
  std::set<std::pair<double, double>> places;
  for (const Seedling& seedling : alive) {
    places.emplace(seedling.position.x, seedling.position.z);
  }
  return places;
}

TEST(ForestLayout, OfTooManyThatDieAtOnceInACompetitionTheLargestLiveOn) {
  std::size_t tooFew = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    bool areTooFewLeft = false;
    const std::set<std::pair<double, double>> expected = survivors(12, seed, &areTooFewLeft);
    tooFew += areTooFewLeft ? 1 : 0;
    std::set<std::pair<double, double>> found;
    for (const TreePlace& place : layoutForest(Spacing::Competition, 12, 1.0, seed)) {
      found.emplace(place.position.x, place.position.z);
    }
    EXPECT_EQ(found, expected) << "seed " << seed;
  }
  EXPECT_GT(tooFew, 3U);
}

}  // namespace
}  // namespace espalier::command::forest_test
