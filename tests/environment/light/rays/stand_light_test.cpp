// The process `light` in stands with known answers: slabs of leaves, view factors, an enclosure without losses.

#include <gtest/gtest.h>

#include <algorithm>

#include "environment/light/sky.h"
#include "tests/environment/light/stand.h"

namespace espalier::environment::stand_light_test {
namespace {

std::string keys(double reflectance, double transmittance, double ground, double side, const std::string& more) {
  const auto number = [](double value) { return std::to_string(value); };
  return R"({"sky":"uniform","sensor":"fluxes","remainder":1e-4,"ground":true,"groundReflectance":[)" + number(ground) +
         R"(],"reflectance":[)" + number(reflectance) + R"(],"transmittance":[)" + number(transmittance) +
         R"(],"plot":[0,)" + number(side) + ",0," + number(side) + "]," + more + "}";
}
const std::string kSky = R"("diffuseIrradiance":1,"directions":32)";
const std::string kSun60 =
    R"("diffuseIrradiance":0,"sun":"direction","directIrradiance":2,"sunDirection":[0.866025404,0.5,0],"directions":32)";

/// Kubelka & Munk's layer of horizontal leaves: k = √((1 − τ)² − ρ²), r = (1 − τ − k)/ρ.
struct Slab {
  double up, down, byPlants;
};
Slab horizontalSlab(double index, double rho, double tau, double ground) {
  double reflected = 0.0;
  double passed = 0.0;
  if (rho + tau == 1.0) {
    reflected = rho * index / (1.0 + rho * index);
    passed = 1.0 - reflected;
  } else {
    const double k = std::sqrt((1.0 - tau) * (1.0 - tau) - rho * rho);
    const double r = (1.0 - tau - k) / rho;
    const double e = core::exp(-2.0 * k * index);
    reflected = r * (1.0 - e) / (1.0 - r * r * e);
    passed = (1.0 - r * r) * core::exp(-k * index) / (1.0 - r * r * e);
  }
  const double down = passed / (1.0 - ground * reflected);
  const double up = reflected + ground * passed * down;
  return {up, down, 1.0 - up - (1.0 - ground) * down};
}

TEST(StandLight, ALayerOfHorizontalLeavesScattersAsItsClosedForm) {
  // of white leaves 0.009 more left upwards when they sent light along the rays that had gathered it; over a white
  // ground 0.02 more came down when its squares sent light in 32 directions each
  for (const auto& [rho, tau, ground] :
       {std::tuple{0.0735, 0.0566, 0.0}, {0.3912, 0.4146, 0.2}, {0.5, 0.5, 0.0}, {0.5, 0.5, 1.0}}) {
    for (const std::string& light : {kSky, kSun60}) {
      Stand stand;
      stand.layer(10, 3, 2, 20'000, true);
      const auto process = openProcess("light", keys(rho, tau, ground, 10, light));
      const StandFluxes fluxes = fluxesOf(*process, stand);
      const Slab exact = horizontalSlab(2, rho, tau, ground);
      EXPECT_NEAR(fluxes.up, exact.up, 0.003) << rho << light;
      EXPECT_NEAR(fluxes.down, exact.down, 0.003) << rho << light;
      EXPECT_NEAR(fluxes.byPlants, exact.byPlants, 0.003) << rho << light;
      EXPECT_NEAR(fluxes.up + fluxes.byPlants + fluxes.byGround, 1, 1e-3);
      EXPECT_NEAR(fieldValue(*process, "leavingUp"), fluxes.up, 1e-12);
      EXPECT_NEAR(fieldValue(*process, "incoming"), 1, 1e-9);
    }
  }
}

TEST(StandLight, ALayerOfSphericalLeavesScattersAsDiscreteOrdinatesSay) {
  // leaf area index 1, PAR leaves over medium soil, a uniform sky: solved by discrete ordinates, error 2e-4
  Stand stand;
  stand.layer(10, 3, 1, 6000, false);
  const auto process = openProcess("light", keys(0.0735, 0.0566, 0.1217, 10, kSky));
  const StandFluxes fluxes = fluxesOf(*process, stand);
  EXPECT_NEAR(fluxes.up, 0.050898, 0.01);
  EXPECT_NEAR(fluxes.byPlants, 0.542414, 0.01);
  EXPECT_NEAR(fluxes.down, 0.46304, 0.01);
}

TEST(StandLight, WithoutLossesAllLightLeavesAgain) {
  // leaves that absorb nothing over a ground that reflects everything
  for (const std::string& light : {kSky, kSun60}) {
    Stand stand;
    stand.layer(10, 3, 3, 3000, false);
    const auto process = openProcess("light", keys(0.5, 0.5, 1, 10, light));
    const StandFluxes fluxes = fluxesOf(*process, stand);
    EXPECT_NEAR(fluxes.up, 1, 1e-3);
    EXPECT_EQ(fluxes.byPlants, 0.0);
    EXPECT_EQ(fluxes.byGround, 0.0);
  }
}

TEST(StandLight, ALeafOverThePlotPassesLightAsATable) {
  // R = ρ + τ² g/(1 − ρ g), T = τ/(1 − ρ g)
  Stand stand;
  stand.rectangle({0, 1, 0}, {0, 0, 4}, {4, 0, 0});
  const auto process = openProcess("light", keys(0.3, 0.4, 0.6, 4, kSky));
  const StandFluxes fluxes = fluxesOf(*process, stand);
  EXPECT_NEAR(fluxes.up, 0.3 + 0.16 * 0.6 / (1 - 0.18), 1e-3);
  EXPECT_NEAR(fluxes.down, 0.4 / (1 - 0.18), 1e-3);
}

TEST(StandLight, SmallSquaresOfTheGroundReflectWhereTheLightFalls) {
  // a black sheet just above half of a white ground: all light that falls beside it leaves again. One square spreads
  // that half over the ground, and the sheet takes about half of it.
  Stand stand;
  stand.rectangle({0, 0.01, 0}, {0, 0, 10}, {5, 0, 0});
  const auto up = [&](const std::string& cells) {
    const std::string light = R"("diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"sunDirection":[0,1,0])";
    return fluxesOf(*openProcess("light", keys(0, 0, 1, 10, light + R"(,"groundCells":)" + cells)), stand).up;
  };
  EXPECT_LT(up("1"), 0.35);
  EXPECT_NEAR(up("16"), 0.5, 0.005);
}

TEST(StandLight, TheMeanOfSunAzimuthsIsThatOfTheirSuns) {
  // an upright sheet of 1 m² gets I sin 60° |cos φ|, without a sun along itself
  Stand stand;
  stand.rectangle({2, 1, 2}, {0, 1, 0}, {0, 0, 1});
  const auto incident = [&](const std::string& azimuths) {
    const auto process = openProcess("light", R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":2,)"
                                              R"("sunDirection":[0.8660254037844386,0.5,0],"sunAzimuths":)" +
                                                  azimuths + "}");
    return *answersOf(*process, stand.queries())[0][2];
  };
  EXPECT_NEAR(incident("1"), 2 * std::sqrt(0.75), 1e-6);
  EXPECT_NEAR(incident("2"), 2 * std::sqrt(0.75), 1e-6);
  EXPECT_NEAR(incident("4"), std::sqrt(0.75), 1e-6);
  EXPECT_NEAR(incident("3"), 2 * std::sqrt(0.75) * 2 / 3, 1e-6);
  EXPECT_NEAR(incident("64"), 2 * std::sqrt(0.75) * 2 / std::numbers::pi, 2e-3);
}

TEST(StandLight, AStandThatIsTurnedByARightAngleKeepsItsFluxes) {
  const auto fluxesTurned = [](bool isTurned) {
    Stand stand;
    for (int i = 0; i < 2000; ++i) {
      const double x = stand.random();
      const double y = stand.random();
      const double z = stand.random();
      const core::Vec3 normal = stand.sphericalNormal();
      // a quarter about the vertical, which takes the plot to itself
      stand.leaf(isTurned ? core::Vec3{z, y, 1 - x} : core::Vec3{x, y, z},
                 isTurned ? core::Vec3{normal.z, normal.y, -normal.x} : normal, 1e-3);
    }
    const auto process = openProcess("light", keys(0.1, 0.1, 0.2, 1, kSky));
    return fluxesOf(*process, stand);
  };
  const StandFluxes before = fluxesTurned(false);
  const StandFluxes after = fluxesTurned(true);
  EXPECT_NEAR(before.up, after.up, 0.003);
  EXPECT_NEAR(before.byPlants, after.byPlants, 0.005);
}

TEST(StandLight, AStandThatIsTurnedWithItsNorthKeepsTheLightOfAMovingSun) {
  // a quarter about the vertical, which takes the plot to itself, and the compass with it
  const auto fluxesTurned = [](bool isTurned) {
    Stand stand;
    for (int i = 0; i < 2000; ++i) {
      const core::Vec3 place{stand.random(), stand.random(), stand.random()};
      const core::Vec3 normal = stand.sphericalNormal();
      stand.leaf(isTurned ? core::Vec3{place.z, place.y, 1 - place.x} : place,
                 isTurned ? core::Vec3{normal.z, normal.y, -normal.x} : normal, 1e-3);
    }
    turtle::EnvironmentContext context;
    context.world.latitudeDegrees = 51;
    context.world.longitudeDegrees = 0;
    context.world.start = "2026-06-21T06:00Z";
    context.world.stepDurationDays = 0.25;
    context.world.north = isTurned ? core::Vec3{-1, 0, 0} : core::Vec3{0, 0, -1};
    const auto process =
        openProcess("light", keys(0.1, 0.1, 0.2, 1, R"("sun":"position","sunSamples":4,"directions":32)"), context);
    const StandFluxes fluxes = fluxesOf(*process, stand);
    const double all = fieldValue(*process, "incoming");
    EXPECT_GT(all, 300);
    return StandFluxes{fluxes.up / all, fluxes.down / all, fluxes.byPlants / all, fluxes.byGround / all};
  };
  const StandFluxes before = fluxesTurned(false);
  const StandFluxes after = fluxesTurned(true);
  EXPECT_NEAR(before.up, after.up, 0.003);
  EXPECT_NEAR(before.byPlants, after.byPlants, 0.005);
}

TEST(StandLight, TheOrderOfPlantsChangesNoLight) {
  // the rays of a leaf are those of its place: drawn in another order it gets the same light, but for the order of sums
  struct Square {
    core::Vec3 corner, first, second;
  };
  Stand random;
  std::vector<Square> leaves;
  for (int i = 0; i < 500; ++i) {
    const core::Vec3 corner{random.random(), random.random(), random.random()};
    const core::Vec3 first = random.sphericalNormal() * 0.06;
    leaves.push_back({corner, first, core::normalised(core::cross(first, random.sphericalNormal())) * 0.06});
  }
  const auto lightOf = [](const std::vector<Square>& drawn) {
    Stand stand;
    for (const Square& leaf : drawn) {
      stand.rectangle(leaf.corner, leaf.first, leaf.second);
    }
    return answersOf(*openProcess("light", keys(0.2, 0.1, 0.2, 4, kSky)), stand.queries());
  };
  const auto expected = lightOf(leaves);
  std::reverse(leaves.begin(), leaves.end());
  auto found = lightOf(leaves);
  std::reverse(found.begin(), found.end());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (std::size_t k = 0; k < expected[i].size(); ++k) {
      EXPECT_NEAR(*found[i][k], *expected[i][k], 1e-9 * (1.0 + std::abs(*expected[i][k]))) << i << " " << k;
    }
  }
}

TEST(StandLight, ThreadsChangeNoBit) {
  Stand stand;
  stand.layer(4, 2, 2, 1500, false);
  const auto one = answersOf(*openProcess("light", keys(0.1, 0.1, 0.2, 4, kSky)), stand.queries());
  const auto three =
      answersOf(*openProcess("light", keys(0.1, 0.1, 0.2, 4, kSky + R"(,"threads":3)")), stand.queries());
  EXPECT_EQ(one, three);
}

// ---- view factors: a black receiver sees a lit sheet of reflectance ρ, and gets ρ F A E of the light E on it

TEST(StandLight, SquaresAtARightAngleExchangeTheirViewFactor) {
  Stand stand;
  stand.rectangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0);  // lit from straight above
  stand.rectangle({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 1);  // standing at its edge
  const auto process = openProcess(
      "light", R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"bounces":1,"directions":65536,)"
               R"("materials":[[0,0.5,0],[1,0,0]]})");
  const auto table = answersOf(*process, stand.queries());
  EXPECT_NEAR(*table[0][1], 0.5, 1e-6);
  EXPECT_NEAR(*table[1][1], 0.5 * 0.20004378, 0.005 * 0.5 * 0.2);
}

TEST(StandLight, OpposedRectanglesExchangeTheirViewFactor) {
  // the sheet above is lit from below by a mirror sun: light from the side passes between them to neither; so the lower
  // one is lit through the upper one, which lets all light through as diffuse light: it emits E downwards
  Stand stand;
  stand.rectangle({0, 1, 0}, {0, 0, 1}, {1, 0, 0}, 0);
  stand.rectangle({0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 1);
  const auto process = openProcess(
      "light", R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"bounces":1,"directions":65536,)"
               R"("materials":[[0,0,1],[1,0,0]]})");
  const auto table = answersOf(*process, stand.queries());
  EXPECT_NEAR(*table[1][1], 0.1998249, 0.005 * 0.2);
}

// ---- numbers of rays, units, spectra

TEST(StandLight, RaysAreDoubledUntilTheErrorIsReached) {
  Stand stand;
  stand.layer(4, 2, 2, 200, false);
  const std::string plot = R"("sky":"uniform","diffuseIrradiance":100,"plot":[0,4,0,4],"bounces":1)";
  const auto lightWith = [&](const std::string& more) {
    std::vector<double> light;
    for (const auto& row : answersOf(*openProcess("light", "{" + plot + more + "}"), stand.queries())) {
      light.push_back(*row[0]);
    }
    return light;
  };
  const auto difference = [](const std::vector<double>& a, const std::vector<double>& b) {
    double squares = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      squares += (a[i] - b[i]) * (a[i] - b[i]);
      sum += b[i];
    }
    const double count = static_cast<double>(a.size());
    return std::sqrt(squares / count) / (sum / count);
  };
  const auto exact = lightWith(R"(,"directions":16384)");
  const double coarse = difference(lightWith(R"(,"directions":16)"), exact);
  EXPECT_GT(coarse, 0.03);
  EXPECT_LT(difference(lightWith(R"(,"directions":16,"error":0.01)"), exact), 0.01);
}

TEST(StandLight, AClearSkyGivesPlanesTheirIrradiance) {
  // the radiance is scaled so that a horizontal plane gets 100; what a tilted leaf gets on both sides follows from it
  const core::Vec3 sun{0.866025403784, 0.5, 0};
  const core::Vec3 normal = core::normalised({0.3, 0.8, 0.5});
  double level = 0.0;
  double tilted = 0.0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double height = (i + 0.5) / kSteps;
    const double width = std::sqrt(1.0 - height * height);
    for (int k = 0; k < kSteps; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k + 0.5) / kSteps;
      const core::Vec3 direction{width * core::cos(angle), height, width * core::sin(angle)};
      const double radiance = skyRadiance(SkyKind::Clear, height, core::dot(direction, sun), sun.y);
      level += radiance * height;
      tilted += radiance * std::abs(core::dot(direction, normal));
    }
  }
  Stand stand;
  stand.leaf({0, 1, 0}, normal, 0.01);
  const std::string keys =
      R"({"sky":"clear","diffuseIrradiance":100,"sun":"direction","directIrradiance":0,"bounces":0,)"
      R"("sunDirection":[0.866025403784,0.5,0],"directions":4096})";
  EXPECT_NEAR(*answersOf(*openProcess("light", keys), stand.queries())[0][2], 100 * tilted / level, 0.5);
  EXPECT_NEAR(*answersOf(*openProcess("light", keys), Stand().sensor(4))[0][2], 100, 0.1);
}

TEST(StandLight, PhotonsOfADayAreMoles) {
  Stand stand;
  stand.rectangle({0, 1, 0}, {0, 0, 1}, {1, 0, 0});
  const auto process =
      openProcess("light", R"({"diffuseIrradiance":100,"unit":"mol","reflectance":[0.1],"transmittance":[0.1]})");
  const auto row = answersOf(*process, stand.queries())[0];
  // 80 W/m² of PAR are 80 · 4.57 µmol/s, in a day 86400 s as many
  EXPECT_NEAR(*row[0], 80 * 4.57 * 86400e-6, 1e-9);
}

TEST(StandLight, BandsFollowFromSpectra) {
  Stand stand;
  stand.rectangle({0, 1, 0}, {0, 0, 1}, {1, 0, 0});
  // light that grows from 0 at 400 nm: its energy up to x is (x − 400)², so three quarters lie in the upper half
  const std::string spectra =
      R"("lightSpectrum":[[400,0],[600,200]],"leafSpectrum":[[400,0.1,0],[500,0.1,0],[500.001,0.1,0.2],[600,0.1,0.2]],)"
      R"("bandLimits":[[400,500],[500,600]])";
  const auto watts =
      answersOf(*openProcess("light", R"({"diffuseIrradiance":400,)" + spectra + "}"), stand.queries(8))[0];
  EXPECT_NEAR(*watts[2], 100, 0.1);
  EXPECT_NEAR(*watts[6], 300, 0.1);
  EXPECT_NEAR(*watts[0], 90, 0.1);
  EXPECT_NEAR(*watts[4], 210, 0.1);
  const auto photons = answersOf(*openProcess("light", R"({"diffuseIrradiance":400,"unit":"umol",)" + spectra + "}"),
                                 stand.queries(8))[0];
  // the mean wavelength of the lower band is 400 + 2/3 · 100 nm, and 1 J of 119.63 nm has 1 µmol
  EXPECT_NEAR(*photons[2] / *watts[2], (400 + 200.0 / 3) / 119.62656582, 1e-3);
}

}  // namespace
}  // namespace espalier::environment::stand_light_test
