// The process `light-voxels` in layers with known answers: Beer's law, Kubelka & Munk, discrete ordinates.

#include <gtest/gtest.h>

#include <cmath>

#include "environment/base/number_text.h"
#include "tests/environment/light/stand.h"

namespace espalier::environment::scattered_light_test {
namespace {

/// A box of 4 x 4 x `layers` voxels of side 1 full of leaves, with a leaf area index.
std::string layer(double index, int layers, const std::string& more) {
  std::string densities;
  for (int i = 0; i < 16 * layers; ++i) {
    densities += (i == 0 ? "" : ",") + std::to_string(index / layers);
  }
  return R"({"gridSize":[4,)" + std::to_string(layers) + R"(,4],"voxelSize":1,"position":[0,0,0],"periodic":true,)" +
         R"("leafAreaDensity":[)" + densities + "]," + more + "}";
}

/// Light on the ground below the layer.
double below(const std::string& configuration) {
  const auto process = openProcess("light-voxels", configuration);
  return *answersOf(*process, QueryBuilder().add({1.3, 0, 2.1}, {0}).batch())[0][0];
}

std::string beam(double zenithDegrees) {
  const double zenith = zenithDegrees * std::numbers::pi / 180;
  return R"("directions":[[)" + numberText(core::sin(zenith)) + "," + numberText(core::cos(zenith)) + ",0,1]]";
}

TEST(VoxelLayers, BlackLeavesPassBeamsByBeersLaw) {
  // G of the ellipsoid with the exact Λ: χ = 2 at 60°, K = √(χ² + tan²θ)/Λ, ε = √(3/4)
  const double epsilon = std::sqrt(0.75);
  const double lambda = 2 + core::log((1 + epsilon) / (1 - epsilon)) / (2 * epsilon * 2);
  for (const auto& [leaves, exponent] : {std::pair<std::string, double>{"\"spherical\"", 0.5 / 0.5},
                                         {"\"horizontal\"", 1.0},
                                         {"\"vertical\"", 2 / std::numbers::pi * std::sqrt(3.0)},
                                         {"\"ellipsoidal\",\"ellipsoidRatio\":2", std::sqrt(4.0 + 3.0) / lambda}}) {
    for (const double index : {1.0, 3.0}) {
      const double passed =
          below(layer(index, 5, "\"leafAngles\":" + leaves + "," + R"("directions":[[0.8660254037844386,0.5,0,1]])"));
      EXPECT_NEAR(passed, core::exp(-exponent * index), 1e-6) << leaves << index;
    }
  }
}

TEST(VoxelLayers, AnEllipsoidOfEqualAxesIsASphere) {
  for (const double zenith : {10.0, 40.0, 75.0}) {
    EXPECT_NEAR(below(layer(2, 3, R"("leafAngles":"ellipsoidal","ellipsoidRatio":1,)" + beam(zenith))),
                below(layer(2, 3, beam(zenith))), 1e-9);
  }
}

TEST(VoxelLayers, BlackLeavesPassSkiesByExponentialIntegrals) {
  // spherical: 2 E₃(L/2) of a uniform sky, 6/7 (E₃ + 2 E₄)(L/2) of an overcast one, by the midpoint rule
  const auto integral = [](int order, double x) {
    double sum = 0.0;
    constexpr int kSteps = 200'000;
    for (int i = 0; i < kSteps; ++i) {
      const double mu = (i + 0.5) / kSteps;
      sum += std::pow(mu, order - 2) * core::exp(-x / mu) / kSteps;
    }
    return sum;
  };
  const std::string many = R"("zenithAngles":24,"azimuthAngles":4)";
  for (const double index : {1.0, 3.0}) {
    EXPECT_NEAR(below(layer(index, 5, R"("sky":"uniform",)" + many)), 2 * integral(3, index / 2), 2e-3);
    EXPECT_NEAR(below(layer(index, 5, R"("sky":"overcast",)" + many)),
                6.0 / 7 * (integral(3, index / 2) + 2 * integral(4, index / 2)), 2e-3);
  }
}

StandFluxes voxelFluxes(const std::string& configuration) {
  const auto process = openProcess("light-voxels", configuration);
  answersOf(*process, QueryBuilder().add({1.3, 0, 2.1}, {0}).batch());
  const StandFluxes fluxes{fieldValue(*process, "leavingUp"), fieldValue(*process, "downOnGround"),
                           fieldValue(*process, "absorbedByPlants"), fieldValue(*process, "absorbedByGround")};
  EXPECT_NEAR(fluxes.up + fluxes.byPlants + fluxes.byGround, fieldValue(*process, "incoming"), 2e-4) << configuration;
  return fluxes;
}

std::string scattering(double rho, double tau, double ground) {
  return R"("scattering":true,"reflectance":)" + std::to_string(rho) + R"(,"transmittance":)" + std::to_string(tau) +
         R"(,"groundReflectance":)" + std::to_string(ground) + ",";
}

TEST(VoxelLayers, HorizontalLeavesScatterAsKubelkaAndMunk) {
  for (const auto& [index, rho, tau, ground] :
       {std::tuple{2.0, 0.0735, 0.0566, 0.2}, {4.0, 0.3912, 0.4146, 0.0}, {1.0, 0.3912, 0.4146, 1.0}}) {
    const double k = std::sqrt((1 - tau) * (1 - tau) - rho * rho);
    const double r = (1 - tau - k) / rho;
    const double e = core::exp(-2 * k * index);
    const double reflected = r * (1 - e) / (1 - r * r * e);
    const double passed = (1 - r * r) * core::exp(-k * index) / (1 - r * r * e);
    const double down = passed / (1 - ground * reflected);
    for (const std::string& light : {std::string(R"("sky":"uniform")"), beam(60)}) {
      const StandFluxes fluxes =
          voxelFluxes(layer(index, 20, R"("leafAngles":"horizontal",)" + scattering(rho, tau, ground) + light));
      EXPECT_NEAR(fluxes.down, down, 0.005) << rho << light;
      EXPECT_NEAR(fluxes.up, reflected + ground * passed * down, 0.005);
    }
  }
}

TEST(VoxelLayers, SphericalLeavesScatterAsDiscreteOrdinates) {
  // solutions by discrete ordinates with an error of 2e-4: index, ρ, τ, ground, zenith (0: a uniform sky), up, down
  struct Case {
    double index, rho, tau, ground, zenith, up, down;
  };
  for (const Case& c :
       {Case{1, 0.0735, 0.0566, 0, 27.4643, 0.019267, 0.584012}, Case{1, 0.0735, 0.0566, 0, 60, 0.027539, 0.388915},
        Case{1, 0.0735, 0.0566, 0.1217, 0, 0.050898, 0.46304}, Case{1, 0.0735, 0.0566, 0.964, 0, 0.235371, 0.472984}}) {
    const StandFluxes fluxes = voxelFluxes(layer(
        c.index, 10, scattering(c.rho, c.tau, c.ground) + (c.zenith > 0 ? beam(c.zenith) : R"("sky":"uniform")")));
    EXPECT_NEAR(fluxes.up, c.up, 0.005) << c.zenith << " " << c.ground;
    EXPECT_NEAR(fluxes.down, c.down, 0.005);
  }
}

TEST(VoxelLayers, WithoutLossesAllLightLeavesAgain) {
  const StandFluxes fluxes = voxelFluxes(layer(3, 10, scattering(0.5, 0.5, 1) + R"("sky":"uniform")"));
  EXPECT_NEAR(fluxes.up, 1, 1e-3);
  EXPECT_EQ(fluxes.byPlants, 0.0);
}

TEST(VoxelLayers, ScatteredLightReachesTheAnswers) {
  const std::string keys = R"("leafAngles":"horizontal",)" + scattering(0.4, 0.4, 0.5) + R"("sky":"uniform")";
  const auto process = openProcess("light-voxels", layer(2, 20, keys));
  const auto rows = answersOf(*process, QueryBuilder().add({1, 0.01, 2}, {0}).add({1, 10, 2}, {0, 0, 0, 0, 0}).batch());
  EXPECT_NEAR(*rows[0][0], fieldValue(*process, "downOnGround"), 0.02) << "near the ground";
  // two flux equations in the middle of the layer: what a leaf absorbs is the part 1 − ρ − τ of light from both sides
  EXPECT_GT(*rows[1][0], core::exp(-1.0)) << "more than the light that has not met a leaf";
  double absorbed = 0.0;
  QueryBuilder all;
  for (int i = 0; i < 20; ++i) {
    all.add({1, i + 0.5, 2}, {0, 0, 0, 0, 0});
  }
  for (const auto& row : answersOf(*process, all.batch())) {
    absorbed += *row[4] * 2 / 20;
  }
  EXPECT_NEAR(absorbed, fieldValue(*process, "absorbedByPlants"), 2e-3);
}

TEST(VoxelLayers, ASensorGetsTheFluxesOfTheStand) {
  const std::string keys = scattering(0.3, 0.2, 0.5) + R"("irradiance":400,"sensor":"fluxes","sky":"uniform")";
  const auto process = openProcess("light-voxels", layer(2, 5, keys));
  const auto rows = answersOf(
      *process, QueryBuilder().add({1, 9, 2}, {0, 0, 0, 0, 0}).add({1, 2, 2}, {0}).add({1, 2, 2}, {1e-9}).batch());
  EXPECT_EQ(*rows[0][0], fieldValue(*process, "leavingUp"));
  EXPECT_EQ(*rows[0][1], fieldValue(*process, "downOnGround"));
  EXPECT_EQ(*rows[0][2], fieldValue(*process, "absorbedByPlants"));
  EXPECT_EQ(*rows[0][3], fieldValue(*process, "absorbedByGround"));
  EXPECT_NEAR(*rows[0][0] + *rows[0][2] + *rows[0][3], 400, 0.1);
  EXPECT_EQ(*rows[1][0], *rows[0][0]) << "a query of one parameter";
  EXPECT_NE(*rows[2][0], *rows[0][0]) << "a leaf gets its light";
}

TEST(VoxelLayers, LeavesOfManyDensitiesBesideEachOtherGiveTheLightOfTheSumOfTheirWays) {
  // black leaves: a beam in the plane of x and y at 45° passes voxels of the densities d, and exp(−Σ G d s) is left
  const auto process = openProcess(
      "light-voxels",
      R"({"gridSize":[3,2,1],"voxelSize":1,"position":[0,0,0],"periodic":true,"scattering":true,"reflectance":0,)"
      R"("transmittance":0,"groundReflectance":0,"directions":[[0.7071067811865476,0.7071067811865476,0,1]],)"
      R"("leafAreaDensity":[1,0,2,0.5,3,0]})");
  answersOf(*process, QueryBuilder().add({1, 0, 0.5}, {0}).batch());
  // from the middle of the top of column x: half a way through it and half through the next one, in both layers
  const std::array<double, 3> lower{1, 0, 2};
  const std::array<double, 3> upper{0.5, 3, 0};
  double passed = 0.0;
  for (std::size_t x = 0; x < 3; ++x) {
    const double sum = upper[x] + upper[(x + 2) % 3] + lower[(x + 2) % 3] + lower[(x + 1) % 3];
    passed += core::exp(-0.5 * sum * std::sqrt(0.5)) / 3;
  }
  EXPECT_NEAR(fieldValue(*process, "downOnGround"), passed, 1e-12);
  EXPECT_NEAR(fieldValue(*process, "absorbedByPlants"), 1 - passed, 1e-12);
}

TEST(VoxelLayers, ABoxThatStandsAloneBalancesWithItsSides) {
  const auto process = openProcess(
      "light-voxels",
      R"({"gridSize":[3,3,3],"voxelSize":1,"position":[0,0,0],"scattering":true,"reflectance":0.3,"transmittance":0.3,)"
      R"("leafAreaDensity":[1,0,1,0,2,0,1,0,1,1,1,1,1,3,1,0,0,0,1,1,1,1,1,1,1,1,1]})");
  answersOf(*process, QueryBuilder().add({1.3, 0, 2.1}, {0}).batch());
  EXPECT_NEAR(fieldValue(*process, "leavingUp") + fieldValue(*process, "leavingAside") +
                  fieldValue(*process, "absorbedByPlants") + fieldValue(*process, "absorbedByGround"),
              fieldValue(*process, "incoming"), 2e-4 * fieldValue(*process, "incoming"));
  EXPECT_GT(fieldValue(*process, "incoming"), 1.0) << "light comes through the sides too";
}

TEST(VoxelLayers, AStandThatIsTurnedByARightAngleKeepsItsFluxes) {
  const auto fluxes = [](bool isTurned) {
    std::string densities;
    for (int z = 0; z < 3; ++z) {
      for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
          const int number = isTurned ? 9 * (2 - x) + 3 * y + z : 9 * z + 3 * y + x;
          densities += (densities.empty() ? "" : ",") + std::to_string(number * number % 7);
        }
      }
    }
    return voxelFluxes(R"({"gridSize":[3,3,3],"voxelSize":1,"position":[0,0,0],"periodic":true,)" +
                       scattering(0.3, 0.3, 0.2) + R"("sky":"overcast","leafAreaDensity":[)" + densities + "]}");
  };
  const StandFluxes before = fluxes(false);
  const StandFluxes after = fluxes(true);
  EXPECT_NEAR(before.up, after.up, 1e-12);
  EXPECT_NEAR(before.down, after.down, 1e-12);
  EXPECT_NEAR(before.byPlants, after.byPlants, 1e-12);
}

}  // namespace
}  // namespace espalier::environment::scattered_light_test
