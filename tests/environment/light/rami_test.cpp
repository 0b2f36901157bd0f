// Open forest canopies of RAMI4PILPS (Widlowski et al. 2011, J. Geophys. Res. 116, G02019; reference: raytran): crowns
// of radius 5 m with 0.75 m² of leaves in a cubic metre over a plain, in a plot of 250 m that repeats itself. Fluxes
// are facts of the publication; the places of the crowns are our own.

#include <gtest/gtest.h>

#include "environment/base/number_text.h"
#include "tests/environment/light/stand.h"

namespace espalier::environment::rami_test {
namespace {

constexpr double kRadius = 5;

struct Forest {
  const char* name;
  int crowns;
  double rho, tau, ground, zenith;  // zenith 0: a uniform sky
  double absorbed, reflected;
};

/// Crowns at random that do not meet in the repeated plot, centres 7 to 11 m high.
std::vector<core::Vec3> crownsOf(int count, double side) {
  Stand random;
  std::vector<core::Vec3> crowns;
  const auto apart = [side](double a, double b) {
    const double distance = std::abs(a - b);
    return std::min(distance, side - distance);
  };
  while (crowns.size() < static_cast<std::size_t>(count)) {
    const core::Vec3 place{side * random.random(), 7 + 4 * random.random(), side * random.random()};
    const bool isFree = std::none_of(crowns.begin(), crowns.end(), [&](const core::Vec3& other) {
      return std::hypot(apart(place.x, other.x), apart(place.z, other.z)) < 2 * kRadius &&
             core::length({apart(place.x, other.x), place.y - other.y, apart(place.z, other.z)}) < 2 * kRadius;
    });
    if (isFree) {
      crowns.push_back(place);
    }
  }
  return crowns;
}

constexpr double kSide = 250;
const double kLeafArea = 0.75 * 4 / 3 * std::numbers::pi * kRadius * kRadius * kRadius;

StandFluxes rayFluxes(const Forest& forest, std::size_t leaves, double azimuthDegrees = 30) {
  Stand stand;
  for (const core::Vec3& crown : crownsOf(forest.crowns, kSide)) {
    stand.crown(crown, kRadius, kLeafArea, leaves);
  }
  const auto list = [](double number) { return "[" + numberText(number) + "]"; };
  std::string light = R"("sky":"uniform","diffuseIrradiance":1)";
  if (forest.zenith > 0) {
    const double zenith = forest.zenith * std::numbers::pi / 180;
    const double azimuth = azimuthDegrees * std::numbers::pi / 180;
    light = R"("diffuseIrradiance":0,"sun":"direction","directIrradiance":)" + numberText(1 / core::cos(zenith)) +
            R"(,"sunDirection":[)" + numberText(core::sin(zenith) * core::cos(azimuth)) + "," +
            numberText(core::cos(zenith)) + "," + numberText(core::sin(zenith) * core::sin(azimuth)) + "]";
  }
  const auto process =
      openProcess("light", R"({"plot":[0,250,0,250],"ground":true,"sensor":"fluxes","remainder":1e-4,"directions":16,)"
                           R"("groundReflectance":)" +
                               list(forest.ground) + R"(,"reflectance":)" + list(forest.rho) + R"(,"transmittance":)" +
                               list(forest.tau) + "," + light + "}");
  return fluxesOf(*process, stand);
}

/// A quarter of the plot with a quarter of the crowns.
StandFluxes voxelFluxes(const Forest& forest) {
  constexpr int kWide = 125;
  constexpr int kLayers = 16;
  // leaf area density of the voxels, each sampled at 64 points
  std::vector<double> densities(std::size_t{kWide} * kWide * kLayers, 0.0);
  for (const core::Vec3& crown : crownsOf(forest.crowns / 4, kWide)) {
    const int points = 4 * static_cast<int>(kRadius) + 2;
    for (int i = 0; i < 2 * points * 2 * points * 2 * points; ++i) {
      const core::Vec3 own{(i % (2 * points) - points + 0.5) / 4, (i / (2 * points) % (2 * points) - points + 0.5) / 4,
                           (i / (4 * points * points) - points + 0.5) / 4};
      if (core::length(own) < kRadius) {
        const core::Vec3 place = crown + own;
        const auto wrapped = [&](double at) {
          return static_cast<int>(std::floor(at - kWide * std::floor(at / kWide))) % kWide;
        };
        const auto layer = static_cast<int>(std::floor(place.y));
        densities[static_cast<std::size_t>((wrapped(place.z) * kLayers + layer) * kWide + wrapped(place.x))] +=
            0.75 / 64;
      }
    }
  }
  std::string text;
  for (const double density : densities) {
    text += (text.empty() ? "" : ",") + numberText(density);
  }
  std::string light = R"("sky":"uniform")";
  if (forest.zenith > 0) {
    const double zenith = forest.zenith * std::numbers::pi / 180;
    light = R"("directions":[[)" + numberText(core::sin(zenith) * core::cos(0.5)) + "," +
            numberText(core::cos(zenith)) + "," + numberText(core::sin(zenith) * core::sin(0.5)) + ",1]]";
  }
  const auto process = openProcess(
      "light-voxels",
      R"({"gridSize":[125,16,125],"voxelSize":1,"position":[0,0,0],"periodic":true,"scattering":true,"reflectance":)" +
          numberText(forest.rho) + R"(,"transmittance":)" + numberText(forest.tau) + R"(,"groundReflectance":)" +
          numberText(forest.ground) + R"(,"leafAreaDensity":[)" + text + "]," + light + "}");
  answersOf(*process, QueryBuilder().add({1, 0.5, 1}, {0}).batch());
  return {fieldValue(*process, "leavingUp"), fieldValue(*process, "downOnGround"),
          fieldValue(*process, "absorbedByPlants"), fieldValue(*process, "absorbedByGround")};
}

constexpr Forest kPar60{"PAR, snow, 60 degrees", 80, 0.0735, 0.0566, 0.964, 60, 0.282001, 0.687909};
constexpr Forest kPar27{"PAR, medium soil, 27 degrees", 80, 0.0735, 0.0566, 0.1217, 27.4643, 0.108971, 0.097594};

TEST(Rami, RaysGiveThePublishedFluxesOfOpenForests) {
  for (const Forest& forest : {kPar60, kPar27}) {
    const StandFluxes fluxes = rayFluxes(forest, 2000);
    EXPECT_NEAR(fluxes.byPlants, forest.absorbed, 0.010) << forest.name;
    EXPECT_NEAR(fluxes.up, forest.reflected, 0.010) << forest.name;
    EXPECT_NEAR(fluxes.byPlants + fluxes.up + fluxes.byGround, 1, 1e-3) << forest.name;
  }
}

TEST(Rami, VoxelsGiveThePublishedFluxesOfOpenForests) {
  for (const Forest& forest : {kPar60, kPar27}) {
    const StandFluxes fluxes = voxelFluxes(forest);
    EXPECT_NEAR(fluxes.byPlants, forest.absorbed, 0.020) << forest.name;
    EXPECT_NEAR(fluxes.up, forest.reflected, 0.020) << forest.name;
    EXPECT_NEAR(fluxes.byPlants + fluxes.up + fluxes.byGround, 1, 1e-3) << forest.name;
  }
}

}  // namespace
}  // namespace espalier::environment::rami_test
