#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "environment/hydraulics/plant_trees.h"
#include "environment/hydraulics/uptake_fractions.h"
#include "tests/environment/hydraulics/root_drawing.h"

namespace espalier::environment::kept_plants_test {
namespace {

using Node = HydraulicTree::Node;

/// A root of so many segments, as a plant or behind other plants.
std::vector<Node> rootOf(std::uint32_t plant, std::size_t segments, double radius, std::vector<Node> before = {}) {
  before.push_back({.plant = plant});
  for (std::size_t i = 0; i < segments; ++i) {
    before.push_back({.parent = static_cast<std::uint32_t>(before.size() - 1),
                      .length = 1.0,
                      .radius = radius,
                      .axialConductance = 0.04,
                      .radialConductivity = 0.0002,
                      .plant = plant});
  }
  return before;
}

TEST(PlantTrees, APlantThatDrawsTheSameKeepsItsTrees) {
  const std::vector<double> none(10, 0.0);
  PlantTrees trees;
  RootDrawing drawing;
  drawing.root({0, 0, 0}, 4, 4, 0.1, none).nextPlant().root({5, 0, 0}, 4, 2, 0.1, none);
  trees.update(*drawing.queries().geometry);
  EXPECT_EQ(trees.keptPlants(), 0U);
  trees.update(*drawing.queries().geometry);
  EXPECT_EQ(trees.keptPlants(), 2U);
  EXPECT_EQ(trees.nodes().size(), 8U);

  // the first plant grows: the nodes of the second lie behind it
  RootDrawing grown;
  grown.root({0, 0, 0}, 5, 5, 0.1, none).nextPlant().root({5, 0, 0}, 4, 2, 0.1, none);
  trees.update(*grown.queries().geometry);
  EXPECT_EQ(trees.keptPlants(), 1U);
  ASSERT_EQ(trees.nodes().size(), 9U);
  EXPECT_EQ(trees.nodes()[7].parent, 6U);
  EXPECT_EQ(trees.nodeAt(1, 9, {5, -4, 0}), 8U);
  EXPECT_EQ(trees.nodeAt(0, 99, {0, -5, 0}), 5U);

  trees.update(turtle::Geometry());
  EXPECT_EQ(trees.nodes().size(), 0U);
  EXPECT_FALSE(trees.nodeAt(1, 9, {5, -4, 0}).has_value());
}

TEST(UptakeFractions, APlantWithTheSameNodesKeepsWhatIsKnown) {
  UptakeFractions fractions;
  fractions.update(rootOf(1, 3, 0.1, rootOf(0, 4, 0.1)));
  EXPECT_EQ(fractions.keptPlants(), 0U);
  const double before = fractions.conductanceOf(1);
  fractions.update(rootOf(1, 3, 0.1, rootOf(0, 5, 0.1)));
  EXPECT_EQ(fractions.keptPlants(), 1U);
  EXPECT_EQ(fractions.conductanceOf(1), before);
  fractions.update(rootOf(1, 3, 0.2, rootOf(0, 5, 0.1)));
  EXPECT_EQ(fractions.keptPlants(), 1U);
  EXPECT_GT(fractions.conductanceOf(1), before);
  const auto expected = HydraulicTree(rootOf(1, 3, 0.2, rootOf(0, 5, 0.1))).solve(HydraulicTree::Collar{});
  EXPECT_EQ(fractions.fractions(), expected.uptakeFractions);
  EXPECT_EQ(fractions.conductanceOf(0), expected.conductances[0]);
  EXPECT_EQ(fractions.conductanceOf(7), 0.0);
}

/// Draws a plant at random: a root with laterals that may begin beside it.
void drawRoot(std::mt19937& random, double x, RootDrawing& drawing) {
  const auto below = [&](std::uint32_t n) { return static_cast<double>(random() % n); };
  const std::vector<double> sent = {below(9), below(3), 0, 0, 0, 0, 0, 0, 0, 0};
  const std::size_t parts = random() % 4;
  drawing.root({x, 0, 0}, static_cast<double>(parts) + 1.0, parts, 0.1 * (1.0 + below(3)), sent);
  for (std::size_t i = 0; i < parts; ++i) {
    const double y = -below(4);
    drawing.segment({x + (below(4) == 0.0 ? 0.01 : 0.0), y, 0}, {x + 1, y - below(2), below(2)}, 0.1, sent, 1);
  }
}

// the answers of a process that has seen other plants are those of a new one
TEST(KeptPlants, AnswerLikeNewOnes) {
  for (const char* configuration :
       {R"({"collar":"head","collarHead":-500})", R"({"collar":"head","collarHead":-500,"join":0.1})",
        R"({"transpiration":[[0,0.01]],"krTable":[[1,0,0.0002],[1,5,0.0001],[2,0,0.0003]]})"}) {
    std::mt19937 random(7);
    std::vector<std::uint32_t> seeds(5);
    const auto process = openProcess("xylem", configuration, centimetres());
    for (int step = 0; step < 60; ++step) {
      // most plants stay as they are; some grow, come and go
      for (std::uint32_t& seed : seeds) {
        seed = random() % 4 == 0 ? static_cast<std::uint32_t>(random()) : seed;
      }
      RootDrawing drawing;
      for (std::size_t plant = 0; plant < seeds.size(); ++plant) {
        std::mt19937 own(seeds[plant]);
        if (seeds[plant] % 5 != 0) {
          drawRoot(own, 10.0 * static_cast<double>(plant), drawing);
        }
        drawing.nextPlant();
      }
      const auto queries = drawing.queries();
      const auto fresh = openProcess("xylem", configuration, centimetres());
      ASSERT_EQ(answersOf(*process, queries), answersOf(*fresh, queries)) << configuration << " step " << step;
    }
  }
}

}  // namespace
}  // namespace espalier::environment::kept_plants_test
