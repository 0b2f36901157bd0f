#include "environment/hydraulics/leaf_gas.h"

#include <gtest/gtest.h>

#include <cmath>

namespace espalier::environment::leaf_gas_test {
namespace {

/// The reference crop of FAO-56: a surface of 70 s/m, and 208/u s/m in the air above it.
LeafExchange referenceCrop(double temperature, double deficit, double pressure, double wind, double netRadiation) {
  const Air air{temperature, saturationPressure(temperature) - deficit, pressure};
  return leafExchange(air, netRadiation, wind / 208.0, 1.0 / 70.0, false);
}

TEST(LeafGas, ADayInBrusselsIsExample18OfFao56) {
  // Allen et al. 1998, example 18: 16.9 °C, es − ea = 1.997 − 1.409 kPa, 100.1 kPa, 2.078 m/s, Rn = 13.28 MJ m⁻² day⁻¹
  const LeafExchange day = referenceCrop(16.9, 1.997 - 1.409, 100.1, 2.078, 13.28e6 / 86400.0);
  EXPECT_NEAR(day.water * 86400.0 / 3.88, 1.0, 0.01);
}

TEST(LeafGas, AnHourInSenegalIsExample19OfFao56) {
  // Allen et al. 1998, example 19, 14 to 15 h: 38 °C, es − ea = 6.625 − 3.445 kPa, 101.2 kPa, 3.3 m/s, Rn − G = 1.749 −
  // 0.175 MJ m⁻² h⁻¹
  const LeafExchange hour = referenceCrop(38.0, 6.625 - 3.445, 101.2, 3.3, (1.749 - 0.175) * 1e6 / 3600.0);
  EXPECT_NEAR(hour.water * 3600.0 / 0.63, 1.0, 0.01);
}

TEST(LeafGas, NetRadiationIsLatentAndSensibleHeat) {
  for (const double radiation : {-80.0, 0.0, 300.0, 900.0}) {
    for (const double temperature : {-5.0, 20.0, 45.0}) {
      for (const double stomata : {0.0, 1e-5, 0.003, 0.05}) {
        for (const double boundary : {1e-4, 0.003, 0.2}) {
          const Air air{temperature, 0.3 * saturationPressure(temperature), 95.0};
          for (const bool isCurve : {false, true}) {
            const LeafExchange leaf = leafExchange(air, radiation, boundary, stomata, isCurve);
            EXPECT_NEAR(leaf.latent + leaf.sensible, radiation, 1e-6);
          }
          // on the curve vapour leaves by the pressure of saturation at the leaf's own temperature:
          // λE = ρ cp/γ · g (e(T leaf) − e), ρ = P/(1.01 R (T + 273)), γ = cp P/(0.622 λ)
          const LeafExchange leaf = leafExchange(air, radiation, boundary, stomata, true);
          const double path = boundary * stomata / (boundary + stomata);
          const double latent = 0.622 * 2.45e6 / (1.01 * 0.287 * (temperature + 273.0)) * path *
                                (saturationPressure(leaf.temperature) - air.vapourPressure);
          EXPECT_NEAR(leaf.latent, latent, 1e-3);
        }
      }
    }
  }
}

TEST(LeafGas, TheSlopeByTheConductanceIsThatOfADifference) {
  const Air air{25.0, 1.2, 101.3};
  for (const bool isCurve : {false, true}) {
    for (const double stomata : {1e-4, 0.003, 0.02}) {
      const double step = 1e-6 * stomata;
      const double less = leafExchange(air, 400.0, 0.02, stomata - step, isCurve).water;
      const double more = leafExchange(air, 400.0, 0.02, stomata + step, isCurve).water;
      EXPECT_NEAR(leafExchange(air, 400.0, 0.02, stomata, isCurve).byConductance / ((more - less) / (2.0 * step)), 1.0,
                  1e-5);
    }
  }
}

TEST(LeafGas, StomataFollowLightDeficitAndHead) {
  const Stomata stomata{.halfPar = 100.0, .halfDeficit = 1.5, .halfHead = -8000.0, .shape = 4.0};
  EXPECT_NEAR(stomata.openness(100.0, 1.5), 0.25, 1e-12);
  EXPECT_NEAR(stomata.openness(300.0, 0.0), 0.75, 1e-12);
  EXPECT_NEAR(stomata.waterPart(-8000.0), 0.5, 1e-12);
  EXPECT_EQ(stomata.waterPart(0.0), 1.0);
  EXPECT_LT(stomata.waterPart(-16000.0), 0.06);
  EXPECT_NEAR(stomata.waterPartSlope(-5000.0), (stomata.waterPart(-4999.0) - stomata.waterPart(-5001.0)) / 2.0, 1e-9);
}

TEST(LeafGas, TheBoundaryLayerIsThatOfALaminarPlate) {
  // Pohlhausen 1921: Nu = 0.664 Re^½ Pr^⅓; 5 cm along 1 m/s: Re = 3311, Pr = 0.7056, Nu = 34.0, both sides
  EXPECT_NEAR(boundaryConductance(0.05, 1.0), 2.0 * 34.0 * 2.14e-5 / 0.05, 2e-4);
  EXPECT_NEAR(boundaryConductance(0.05, 4.0) / boundaryConductance(0.05, 1.0), 2.0, 1e-12);
  // calm air carries heat away too
  EXPECT_EQ(boundaryConductance(0.05, 0.0), boundaryConductance(0.05, 0.1));
}

}  // namespace
}  // namespace espalier::environment::leaf_gas_test
