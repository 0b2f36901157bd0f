#include "environment/hydraulics/plant_water.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "environment/hydraulics/rhizosphere.h"

namespace espalier::environment::plant_water_test {
namespace {

using Node = HydraulicTree::Node;
using Collar = HydraulicTree::Collar;

constexpr std::array kSoils{SoilLayer{0.045, 0.43, 0.15, 3.0, 1000.0, 1e-6},
                            SoilLayer{0.08, 0.43, 0.04, 1.6, 50.0, 1e-6}, SoilLayer{0.1, 0.4, 0.01, 1.1, 10.0, 1e-6}};

/// A random root system in cm. Conductances lie up to `spread` powers of ten around those of a root.
HydraulicTree randomRoots(std::uint32_t count, double soilHead, double spread, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  std::vector<Node> nodes(1);
  for (std::uint32_t i = 1; i < count; ++i) {
    Node node;
    node.parent = i < 5 ? i - 1 : static_cast<std::uint32_t>(part(random) * i);
    node.length = 0.1 + part(random);
    node.rise = -node.length * part(random);
    node.radius = 0.02 + 0.05 * part(random);
    node.axialConductance = 0.01 * std::pow(10.0, spread * (2.0 * part(random) - 1.0));
    node.radialConductivity = 1e-3 * std::pow(10.0, spread * (2.0 * part(random) - 1.0));
    node.soilHead = soilHead * (0.5 + part(random));
    nodes.push_back(node);
  }
  return HydraulicTree(std::move(nodes));
}

TEST(PlantWater, RootsOfAllKindsFindTheirHeadsInSoilsOfAllKinds) {
  // flow along the xylem is exact for the head at the surface, and soil and root carry the same:
  // 2·half (ψ surface − mean of both ends) = l 2π/g (Φ(soil) − Φ(surface))
  for (const SoilLayer& layer : kSoils) {
    const FluxPotential potential(layer);
    for (const double soilHead : {-5.0, -100.0, -3000.0, -14000.0}) {
      for (const double spread : {0.0, 1.0, 3.0}) {
        for (const Collar& collar : {Collar{.head = -15000.0}, Collar{.hasHead = false, .flow = 0.0},
                                     Collar{.hasHead = false, .flow = 5.0, .lowestHead = -15290.0}}) {
          PlantWater plants(randomRoots(200, soilHead, spread, 7), {}, {});
          for (PlantWater::Soil& soil : plants.soils()) {
            soil = {&potential, annulusFactor(20.0)};
          }
          const auto result = plants.solve(std::span(&collar, 1));
          ASSERT_TRUE(result) << soilHead << " " << spread << " " << result.error();
          EXPECT_LT(result->rounds, 60);
          double uptake = 0.0;
          double all = 0.0;
          for (std::size_t i = 1; i < plants.nodes().size(); ++i) {
            const Node& node = plants.nodes()[i];
            uptake += result->flow.uptakes[i];
            all += std::abs(result->flow.uptakes[i]);
            const double mean = 0.5 * (result->flow.heads[i] + result->flow.heads[node.parent]);
            const double surface = result->surfaceHeads[i];
            const double ofRoot = 2.0 * HydraulicTree::segmentOf(node).half * (surface - mean);
            EXPECT_NEAR(ofRoot, result->flow.uptakes[i], 1e-8 * (all + 1.0));
            if (surface < node.soilHead) {
              EXPECT_NEAR(node.length * 2.0 * M_PI / annulusFactor(20.0) *
                              (potential.at(node.soilHead) - potential.at(surface)),
                          result->flow.uptakes[i], 1e-7 * (all + 1.0));
            }
          }
          EXPECT_NEAR(uptake, result->flow.collarFlows[0], 1e-9 * (all + 1.0));
        }
      }
    }
  }
}

TEST(PlantWater, WaterAtRestInWetSoilStays) {
  // heads fall by one a unit of height. Each segment has one head of soil, so a little water goes round within it; the
  // flows are as small as rounding of the heads allows them to be known
  std::vector<Node> nodes(1);
  for (std::uint32_t i = 0; i < 300; ++i) {
    nodes.push_back({i, 0.3, -0.3, 0.03, 4e-4, 4e-3, -659.8 + 0.3 * i + 0.15});
  }
  const FluxPotential potential(kSoils[1]);
  PlantWater plants(HydraulicTree(nodes), {}, {});
  for (PlantWater::Soil& soil : plants.soils()) {
    soil = {&potential, annulusFactor(20.0)};
  }
  const Collar none{.hasHead = false, .flow = 0.0};
  const auto result = plants.solve(std::span(&none, 1));
  ASSERT_TRUE(result) << result.error();
  EXPECT_LT(result->rounds, 10);
  EXPECT_NEAR(result->flow.heads[0], -659.8, 0.02);
  EXPECT_NEAR(result->flow.collarFlows[0], 0.0, 1e-10);
}

TEST(PlantWater, UptakesChangeWithTheHeadsOfTheSoilAsADifferenceDoes) {
  const FluxPotential potential(kSoils[1]);
  for (const Collar& collar : {Collar{.head = -9000.0}, Collar{.hasHead = false, .flow = 0.01}}) {
    PlantWater plants(randomRoots(60, -500.0, 1.0, 3), {}, {});
    for (PlantWater::Soil& soil : plants.soils()) {
      soil = {&potential, annulusFactor(20.0)};
    }
    const auto before = plants.solve(std::span(&collar, 1));
    ASSERT_TRUE(before);
    std::vector<double> changes(60, 0.0);
    for (std::size_t i = 1; i < changes.size(); ++i) {
      changes[i] = 1e-4 * static_cast<double>(i % 7);
    }
    const std::vector<double> expected = plants.changeOf(*before, changes);
    for (std::size_t i = 0; i < changes.size(); ++i) {
      plants.nodes()[i].soilHead += changes[i];
    }
    const auto after = plants.solve(std::span(&collar, 1));
    ASSERT_TRUE(after);
    for (std::size_t i = 1; i < changes.size(); ++i) {
      EXPECT_NEAR(after->flow.uptakes[i] - before->flow.uptakes[i], expected[i], 1e-3 * std::abs(expected[i]) + 1e-11);
    }
  }
}

/// 40 cm of root and a stem with 30 leaves that together have so many cm².
PlantWater plantWithLeaves(double area, double soilHead, double shape, const FluxPotential* potential) {
  std::vector<Node> nodes(1);
  for (std::uint32_t i = 0; i < 40; ++i) {
    nodes.push_back({i, 1.0, -1.0, 0.05, 0.2, 0.001, soilHead});
  }
  for (std::uint32_t i = 0; i < 30; ++i) {
    nodes.push_back({i == 0 ? 0 : 40 + i, 1.0, 1.0, 0.1, 0.5, 0.0, 0.0});
  }
  PlantWater plants(HydraulicTree(nodes), {}, {});
  plants.setStomata({.most = 0.01, .halfHead = -8000.0, .shape = shape}, false);
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (i > 40) {
      plants.gasLeaves()[i] = {.flow = area * 8640.0 / 30.0,
                               .netRadiation = 400.0,
                               .boundary = 0.02,
                               .open = 0.01,
                               .air = {25.0, 1.5, 101.3}};
    } else if (potential != nullptr) {
      plants.soils()[i] = {potential, annulusFactor(20.0)};
    }
  }
  return plants;
}

TEST(PlantWater, StomataCloseAsTheSoilDriesAndFindTheirHeads) {
  // few and many leaves, steep and flat responses to the head, soil that resists or not
  const FluxPotential loam(kSoils[1]);
  for (const double area : {1.0, 10.0, 1000.0}) {
    for (const double shape : {1.0, 4.0, 20.0}) {
      for (const FluxPotential* potential : {static_cast<const FluxPotential*>(nullptr), &loam}) {
        double before = HUGE_VAL;
        for (const double soilHead : {-100.0, -2000.0, -6000.0, -9000.0, -14000.0}) {
          PlantWater plants = plantWithLeaves(area, soilHead, shape, potential);
          const Collar none{.hasHead = false, .flow = 0.0, .lowestHead = -1e12};
          const auto result = plants.solve(std::span(&none, 1));
          ASSERT_TRUE(result) << area << " " << shape << " " << soilHead << " " << result.error();
          EXPECT_LT(result->rounds, 200) << area << " " << shape << " " << soilHead;
          double given = 0.0;
          double taken = 0.0;
          for (std::size_t i = 1; i < plants.nodes().size(); ++i) {
            given += result->given[i];
            taken += result->flow.uptakes[i];
          }
          // some thousand cm² of leaf on 40 cm of root stop at heads of −10⁹ cm, where rounding of heads is all that is
          // left
          EXPECT_NEAR(given, taken, 5e-3 * given);
          EXPECT_LT(given, before);
          before = given;
        }
      }
    }
  }
}

}  // namespace
}  // namespace espalier::environment::plant_water_test
