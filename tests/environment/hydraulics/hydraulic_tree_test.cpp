#include "environment/hydraulics/hydraulic_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace espalier::environment::hydraulic_tree_test {
namespace {

using Node = HydraulicTree::Node;

/// A root straight down in parts, cm and day.
std::vector<Node> straightRoot(std::uint32_t parts, double length, double radius, double kx, double kr,
                               double soilHead) {
  std::vector<Node> nodes(1);
  for (std::uint32_t i = 0; i < parts; ++i) {
    nodes.push_back({i, length / parts, -length / parts, radius, kx, kr, soilHead});
  }
  return nodes;
}

TEST(HydraulicTree, ASingleRootIsExactWithAnyNumberOfSegments) {
  // benchmark M3.1 (Schnepf et al. 2020). u = ψ − ψs: u'' = c u, u = −800 at the collar; no flow at the tip: u' = 1
  const double a = 0.2;
  const double kx = 0.0432;
  const double kr = 0.000173;
  const double tau = std::sqrt(2.0 * std::numbers::pi * a * kr / kx);
  const double u0 = -800.0;
  const double b = (1.0 / tau - u0 * std::sinh(50.0 * tau)) / std::cosh(50.0 * tau);
  const double tip = u0 * std::cosh(50.0 * tau) + b * std::sinh(50.0 * tau) - 200.0;
  EXPECT_NEAR(tip, -231.98798, 1e-5);  // the published value
  for (const std::uint32_t parts : {1U, 7U, 500U}) {
    const HydraulicTree tree(straightRoot(parts, 50.0, a, kx, kr, -200.0));
    const auto result = tree.solve({.head = -1000.0});
    for (std::uint32_t i = 0; i <= parts; ++i) {
      const double s = 50.0 * i / parts;
      const double expected = u0 * std::cosh(tau * s) + b * std::sinh(tau * s) - 200.0;
      EXPECT_NEAR(result.heads[i] / expected, 1.0, 1e-9);
    }
    EXPECT_NEAR(result.collarFlows[0], 2.406878, 1e-6);
  }
}

TEST(HydraulicTree, TheConductanceOfARootIsThatOfLandsbergAndFowkes) {
  // √(2πa kr kx) tanh(√(2πa kr/kx) L), without gravity (1978)
  for (const double length : {0.01, 3.0, 50.0, 4000.0}) {
    const HydraulicTree tree(straightRoot(3, length, 0.05, 0.00432, 0.00173, 0.0));
    const double c = 2.0 * std::numbers::pi * 0.05 * 0.00173;
    EXPECT_NEAR(tree.solve({.head = -1.0}).conductances[0] /
                    (std::sqrt(c * 0.00432) * std::tanh(std::sqrt(c / 0.00432) * length)),
                1.0, 1e-9);
  }
}

/// A random tree with segments in all directions; no water crosses the surface of every fifth.
HydraulicTree randomTree(std::uint32_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  std::vector<Node> nodes(1);
  for (std::uint32_t i = 1; i < count; ++i) {
    Node node;
    node.parent = static_cast<std::uint32_t>(part(random) * i);
    node.length = 0.1 + part(random);
    node.rise = node.length * (2.0 * part(random) - 1.0);
    node.radius = 0.01 + 0.1 * part(random);
    node.axialConductance = 0.01 + part(random);
    node.radialConductivity = i % 5 == 0 ? 0.0 : 1e-3 * part(random);
    node.soilHead = -500.0 * part(random);
    nodes.push_back(node);
  }
  return HydraulicTree(std::move(nodes));
}

TEST(HydraulicTree, WhatEntersLeavesAtTheCollar) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const HydraulicTree tree = randomTree(2000, seed);
    const auto result = tree.solve({.head = -3000.0});
    double uptake = 0.0;
    double fractions = 0.0;
    for (std::size_t i = 0; i < result.uptakes.size(); ++i) {
      uptake += result.uptakes[i];
      fractions += result.uptakeFractions[i];
    }
    EXPECT_NEAR(uptake / result.collarFlows[0], 1.0, 1e-10);
    EXPECT_NEAR(fractions, 1.0, 1e-12);
  }
}

TEST(HydraulicTree, UptakeFollowsTheFractionsInSoilAtOneTotalHead) {
  // horizontal segments have no gravity: uptake = Krs · difference of heads · fraction (Couvreur et al. 2012)
  HydraulicTree tree = randomTree(500, 7);
  for (Node& node : tree.nodes()) {
    node.rise = 0.0;
    node.soilHead = -300.0;
  }
  const auto result = tree.solve({.head = -1300.0});
  for (std::size_t i = 0; i < result.uptakes.size(); ++i) {
    EXPECT_NEAR(result.uptakes[i], result.conductances[0] * 1000.0 * result.uptakeFractions[i], 1e-9);
  }
}

TEST(HydraulicTree, AFlowAtTheCollarGivesTheHeadThatGivesTheFlow) {
  const HydraulicTree tree = randomTree(300, 3);
  const double flow = tree.solve({.head = -2000.0}).collarFlows[0];
  const auto result = tree.solve({.hasHead = false, .flow = flow});
  EXPECT_NEAR(result.heads[0], -2000.0, 1e-6);
  // no lower than the lowest head: then less flows
  const auto limited = tree.solve({.hasHead = false, .flow = flow, .lowestHead = -1000.0});
  EXPECT_EQ(limited.heads[0], -1000.0);
  EXPECT_NEAR(limited.collarFlows[0], tree.solve({.head = -1000.0}).collarFlows[0], 1e-9);
  // then the head is given, also when the soil changes (changeOf)
  EXPECT_EQ(result.isFlowGiven[0], 1);
  EXPECT_EQ(limited.isFlowGiven[0], 0);
}

TEST(HydraulicTree, LeavesDrawWhatRootsTakeUp) {
  // a root below and a stem above one collar without flow: the leaf's demand comes from the root alone
  std::vector<Node> nodes = straightRoot(10, 20.0, 0.05, 0.05, 1e-3, -200.0);
  nodes.push_back({0, 30.0, 30.0, 0.2, 0.5, 0.0, 0.0, 0.02});
  const auto result = HydraulicTree(nodes).solve({.hasHead = false, .flow = 0.0});
  double uptake = 0.0;
  for (const double part : result.uptakes) {
    uptake += part;
  }
  EXPECT_NEAR(uptake, 0.02, 1e-12);
  // up the stem: 30 cm of height, and the flow over kx/L
  EXPECT_NEAR(result.heads.back(), result.heads[0] - 30.0 - 0.02 * 30.0 / 0.5, 1e-9);
}

TEST(HydraulicTree, TheCollarsOfAPlantHaveOneHeadAndShareItsFlow) {
  // two roots of one plant, in wet and in dry soil: together they give the flow, each by its own conductance
  std::vector<Node> both = straightRoot(5, 10.0, 0.1, 0.1, 1e-3, -100.0);
  const auto offset = static_cast<std::uint32_t>(both.size());
  for (Node node : straightRoot(5, 10.0, 0.1, 0.1, 1e-3, -400.0)) {
    node.parent = node.parent == HydraulicTree::kNoParent ? node.parent : node.parent + offset;
    both.push_back(node);
  }
  const auto result = HydraulicTree(both).solve({.hasHead = false, .flow = 0.5});
  EXPECT_EQ(result.heads[0], result.heads[offset]);
  ASSERT_EQ(result.collarFlows.size(), 1U);
  EXPECT_NEAR(result.collarFlows[0], 0.5, 1e-12);
  const auto wet = HydraulicTree(straightRoot(5, 10.0, 0.1, 0.1, 1e-3, -100.0)).solve({.head = result.heads[0]});
  const auto dry = HydraulicTree(straightRoot(5, 10.0, 0.1, 0.1, 1e-3, -400.0)).solve({.head = result.heads[0]});
  EXPECT_NEAR(wet.collarFlows[0] + dry.collarFlows[0], 0.5, 1e-10);
  EXPECT_NEAR(result.conductances[0], 2.0 * wet.conductances[0], 1e-12);
}

TEST(HydraulicTree, ALeafThatGivesLessAtALowHeadFindsItsHead) {
  // demand 0.04 + 0.0001 ψ at the top of a stem: the head where roots deliver just that
  std::vector<Node> nodes = straightRoot(10, 20.0, 0.05, 0.05, 1e-3, -200.0);
  Node leaf{0, 30.0, 30.0, 0.2, 0.5};
  leaf.demand = 0.04;
  leaf.demandByHead = 1e-4;
  nodes.push_back(leaf);
  const auto result = HydraulicTree(nodes).solve({.hasHead = false, .flow = 0.0});
  double uptake = 0.0;
  for (const double part : result.uptakes) {
    uptake += part;
  }
  EXPECT_NEAR(uptake, 0.04 + 1e-4 * result.heads.back(), 1e-12);
}

TEST(HydraulicTree, SeveralPlantsAreEachAsAlone) {
  std::vector<Node> both = straightRoot(5, 10.0, 0.1, 0.1, 1e-3, -100.0);
  const std::vector<Node> second = straightRoot(7, 30.0, 0.05, 0.02, 2e-3, -400.0);
  const auto offset = static_cast<std::uint32_t>(both.size());
  for (Node node : second) {
    node.parent = node.parent == HydraulicTree::kNoParent ? node.parent : node.parent + offset;
    node.plant = 1;
    both.push_back(node);
  }
  const auto result = HydraulicTree(both).solve({.head = -800.0});
  const auto alone = HydraulicTree(second).solve({.head = -800.0});
  ASSERT_EQ(result.collarFlows.size(), 2U);
  EXPECT_EQ(result.collarFlows[1], alone.collarFlows[0]);
  EXPECT_EQ(result.uptakeFractions[offset + 4], alone.uptakeFractions[4]);
}

}  // namespace
}  // namespace espalier::environment::hydraulic_tree_test
