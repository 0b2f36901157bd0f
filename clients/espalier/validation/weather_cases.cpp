// Leaves in the weather: the examples of FAO-56 (Allen et al. 1998), their energy balance, and light from skies.

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "clients/espalier/validation/canopy_fluxes.h"
#include "clients/espalier/validation/process_run.h"
#include "clients/espalier/validation/validation.h"
#include "engine/core/elementary.h"
#include "environment/base/air.h"
#include "environment/hydraulics/leaf_gas.h"

namespace espalier::validation {

namespace {

using core::Vec3;
using std::numbers::pi;

// ---- FAO-56

/// Water that the reference crop gives off, kg m⁻² s⁻¹: a surface of 70 s/m, and 208/u s/m in the air above it. The
/// vapour deficit and the pressure are in kPa, the wind u in m/s, the net radiation in W/m².
double referenceCrop(double temperature, double deficit, double pressure, double wind, double netRadiation) {
  const environment::Air air{temperature, environment::saturationPressure(temperature) - deficit, pressure};
  return environment::leafExchange(air, netRadiation, wind / 208.0, 1.0 / 70.0, false).water;
}

CaseResult referenceEvaporation(const Data&) {
  CaseResult result;
  // example 18: es − ea = 1.997 − 1.409 kPa, Rn = 13.28 MJ m⁻² day⁻¹
  const double day = referenceCrop(16.9, 1.997 - 1.409, 100.1, 2.078, 13.28e6 / 86400.0) * 86400.0;
  // example 19: es − ea = 6.625 − 3.445 kPa, Rn − G = 1.749 − 0.175 MJ m⁻² h⁻¹
  const double hour = referenceCrop(38.0, 6.625 - 3.445, 101.2, 3.3, (1.749 - 0.175) * 1e6 / 3600.0) * 3600.0;
  LargestError residual;
  for (const double radiation : {-80.0, 0.0, 300.0, 900.0}) {
    for (const double temperature : {-5.0, 20.0, 45.0}) {
      for (const double stomata : {0.0, 1e-5, 0.003, 0.05}) {
        for (const double boundary : {1e-4, 0.003, 0.2}) {
          const environment::Air air{temperature, 0.3 * environment::saturationPressure(temperature), 95.0};
          for (const bool isCurve : {false, true}) {
            const auto leaf = environment::leafExchange(air, radiation, boundary, stomata, isCurve);
            // λE by the vapour that leaves, H by the temperature of the leaf: ρ cp g (T leaf − T air)
            const double warmth = air.density() * environment::kAirHeat * boundary * (leaf.temperature - temperature);
            residual.add(std::abs(radiation - environment::kLatentHeat * leaf.water - warmth));
          }
        }
      }
    }
  }
  result.rows = {{"example 18, a day in Brussels, 3.88 mm/day, relative", std::abs(day / 3.88 - 1.0), 0.01, ""},
                 {"example 19, 14 to 15 h in Senegal, 0.63 mm/h, relative", std::abs(hour / 0.63 - 1.0), 0.01, ""},
                 {"energy that 288 leaves keep, W/m2", residual.value(), 0.1, ""}};
  return result;
}

// ---- skies

/// Radiance of the CIE standard general sky of type 12, 5 or 1, but for a factor: a, b of the gradation and c, d, e of
/// the indicatrix (CIE S 011, 2003).
double generalSky(const std::string& sky, const Vec3& direction, const Vec3& sun) {
  if (sky == "uniform") {
    return 1.0;
  }
  if (sky == "overcast") {
    return (1.0 + 2.0 * direction.y) / 3.0;
  }
  constexpr double kA = -1.0, kB = -0.32, kC = 10.0, kD = -3.0, kE = 0.45;
  const double cosine = core::dot(direction, sun);
  return (1.0 + kA * core::exp(kB / direction.y)) *
         (1.0 + kC * (core::exp(kD * core::acos(cosine)) - core::exp(kD * pi / 2.0)) + kE * cosine * cosine);
}

/// The light on both sides of a leaf together from a sky that gives a horizontal plane 1, by the midpoint rule.
double lightOfSky(const std::string& sky, const Vec3& sun, const Vec3& normal) {
  constexpr int kUp = 400;
  constexpr int kAround = 800;
  double onLeaf = 0.0;
  double onGround = 0.0;
  for (int i = 0; i < kUp; ++i) {
    const double cosine = (i + 0.5) / kUp;
    const double sine = std::sqrt(1.0 - cosine * cosine);
    for (int k = 0; k < kAround; ++k) {
      const double angle = 2.0 * pi * (k + 0.5) / kAround;
      const Vec3 direction{sine * core::cos(angle), cosine, sine * core::sin(angle)};
      const double radiance = generalSky(sky, direction, sun);
      onLeaf += radiance * std::abs(core::dot(direction, normal));
      onGround += radiance * cosine;
    }
  }
  return onLeaf / onGround;
}

CaseResult skies(const Data&) {
  const std::array<std::pair<const char*, Vec3>, 3> leaves{
      {{"flat", {0, 1, 0}}, {"across the sun", {1, 0, 0}}, {"along the sun", {0, 0, 1}}}};
  std::array<LargestError, 3> errors;
  for (const std::string sky : {"uniform", "overcast", "clear"}) {
    for (const double zenith : {20.0, 50.0, 75.0}) {
      const Vec3 sun{core::sin(zenith * pi / 180.0), core::cos(zenith * pi / 180.0), 0.0};
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        environment::Canopy canopy;
        const auto [up, aside] = i == 0   ? std::pair(Vec3{0, 0, 1}, Vec3{1, 0, 0})
                                 : i == 1 ? std::pair(Vec3{0, 1, 0}, Vec3{0, 0, 1})
                                          : std::pair(Vec3{1, 0, 0}, Vec3{0, 1, 0});
        canopy.rectangle({0, 1, 0}, up, aside);
        turtle::QueryBatch queries = queriesAt({{}}, std::vector<double>(4, 0.0));
        queries.geometry = canopy.geometry();
        const std::string keys = R"({"sky":")" + sky + R"(","diffuseIrradiance":1,"sun":"direction",)" +
                                 R"("directIrradiance":0,"directions":65536,"reflectance":0,"transmittance":0,)" +
                                 R"("sunDirection":)" + listOf({sun.x, sun.y, sun.z}) + "}";
        const double found = runProcess("light", keys, queries).replies.values[2];
        errors[i].add(std::abs(found / lightOfSky(sky, sun, leaves[i].second) - 1.0));
      }
    }
  }
  CaseResult result;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    result.rows.push_back(
        {std::string("light, a leaf ") + leaves[i].first + ", three skies, relative", errors[i].value(), 1e-3, ""});
  }
  return result;
}

}  // namespace

std::span<const Case> weatherCases() {
  static constexpr std::array<Case, 2> kCases{
      {{"fao56", "Evaporation of the reference crop (Allen et al. 1998, FAO-56), energy balance of leaves", true,
        referenceEvaporation},
       {"skies", "Light of uniform, overcast and clear skies on leaves (CIE standard general skies 5, 1 and 12)", true,
        skies}}};
  return kCases;
}

}  // namespace espalier::validation
