#include "environment/base/air.h"

#include <gtest/gtest.h>

#include <cmath>

#include "environment/hydraulics/leaf_gas.h"

namespace espalier::environment::air_test {
namespace {

TEST(Air, TheAirOverGrassResistsAsFao56Says) {
  // Allen et al. 1998, equation 4 and box 4: grass of 0.12 m lifts the wind by 0.08 m, its roughness is 0.123 of its
  // height, wind at 2 m: 208/u s/m
  EXPECT_NEAR(1.0 / airConductance(1.0, 2.0 - 0.08, 0.123 * 0.12), 208.0, 0.5);
  EXPECT_NEAR(1.0 / airConductance(4.0, 2.0 - 0.08, 0.123 * 0.12), 52.0, 0.2);
}

TEST(Air, AWetSurfaceGivesOffWhatALeafWithOpenStomataDoes) {
  // the energy balance of a leaf on the tangent, whose stomata do not resist
  for (const double temperature : {5.0, 20.0, 38.0}) {
    for (const double humidity : {0.1, 0.9}) {
      const Air air{temperature, humidity * saturationPressure(temperature), 98.0};
      for (const double energy : {-40.0, 0.0, 450.0}) {
        const double leaf = leafExchange(air, energy, 0.02, 1e9, false).water;
        EXPECT_NEAR(wetSurfaceEvaporation(air, energy, 0.02), leaf, 1e-9 * (1e-5 + std::abs(leaf)));
      }
    }
  }
}

TEST(Air, WithoutWindOnlyTheEnergyCounts) {
  const Air air{20.0, 1.0, 101.3};
  // equilibrium: Δ/(Δ + γ) of the energy, Δ = 0.1447 and γ = 0.0673 kPa/K (Allen et al. 1998, tables 2.4 and 2.2)
  EXPECT_NEAR(wetSurfaceEvaporation(air, 100.0, 0.0) * 2.45e6, 100.0 * 0.1447 / (0.1447 + 0.0673), 0.1);
}

}  // namespace
}  // namespace espalier::environment::air_test
