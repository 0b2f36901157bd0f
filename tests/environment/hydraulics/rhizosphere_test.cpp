#include "environment/hydraulics/rhizosphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "environment/soil/flux_potential.h"
#include "tests/environment/soil/soils.h"

namespace espalier::environment::rhizosphere_test {
namespace {

TEST(Rhizosphere, TheUptakeIsWhatSoilAndRootBothCarry) {
  const FluxPotential potential(kLoam);
  const double kRoot = 2.0 * std::numbers::pi * 0.02 * 0.002;  // 2πa kr
  for (const double xylem : {-200.0, -2000.0, -15000.0, -1e6}) {
    const RootUptake uptake =
        rootUptake(potential, annulusFactor(20.0), soilPointAt(potential, -150.0), kRoot, xylem, -150.0);
    const double ofRoot = 2.0 * std::numbers::pi * 0.02 * 0.002 * (uptake.surfaceHead - xylem);
    const double ofSoil =
        2.0 * std::numbers::pi / annulusFactor(20.0) * (potential.at(-150.0) - potential.at(uptake.surfaceHead));
    EXPECT_NEAR(uptake.perLength / ofRoot, 1.0, 1e-9);
    EXPECT_NEAR(uptake.perLength / ofSoil, 1.0, 1e-6);
    // its slope, by a difference
    const RootUptake other =
        rootUptake(potential, annulusFactor(20.0), soilPointAt(potential, -150.0), kRoot, xylem * 1.0001, -150.0);
    EXPECT_NEAR((other.perLength - uptake.perLength) / (-0.0001 * xylem) / uptake.byHead, 1.0, 2e-3);
    // and that by the head of the soil
    const RootUptake wetter =
        rootUptake(potential, annulusFactor(20.0), soilPointAt(potential, -149.99), kRoot, xylem, -150.0);
    EXPECT_NEAR((wetter.perLength - uptake.perLength) / 0.01 / uptake.bySoilHead, 1.0, 2e-3);
  }
  // water that leaves a root meets the root alone
  EXPECT_NEAR(rootUptake(potential, 2.0, soilPointAt(potential, -150.0), kRoot, -50.0, 0.0).perLength,
              -100.0 * 2.0 * std::numbers::pi * 0.02 * 0.002, 1e-12);
}

TEST(Rhizosphere, FactorsAreThoseOfTheirLimits) {
  // far away ln ρ − 3/4 (Schröder et al. 2008); next to the root (ρ² − 1)/6; ln(0.198 Δx/a) (Peaceman 1978)
  EXPECT_NEAR(annulusFactor(1e4), std::log(1e4) - 0.75, 1e-6);
  EXPECT_NEAR(annulusFactor(std::sqrt(1.0009)) / annulusFactor(std::sqrt(1.0011)), 9.0 / 11.0, 1e-4);
  EXPECT_NEAR(cellFactor(1.0, 0.01).factor, std::log(19.8), 1e-12);
  EXPECT_EQ(cellFactor(1.0, 0.01).reach, 0U);
  // 9 cells: 9 pairs of one cell, 24 at the distance 1, 16 at √2, 12 at 2, 16 at √5, 4 at √8
  const double nine = (9 * std::log(0.198) + 16 * std::log(2.0) / 2 + 12 * std::log(2.0) + 16 * std::log(5.0) / 2 +
                       4 * std::log(8.0) / 2) /
                      81;
  EXPECT_EQ(cellFactor(0.04, 0.01).reach, 1U);
  EXPECT_NEAR(cellFactor(0.04, 0.01).factor, std::log(4.0) + nine, 1e-12);
  EXPECT_EQ(cellFactor(1.0, 1000.0).factor, 0.0);
}

}  // namespace
}  // namespace espalier::environment::rhizosphere_test
