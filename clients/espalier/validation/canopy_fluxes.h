#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/validation/canopy.h"
#include "clients/espalier/validation/validation.h"
#include "engine/core/elementary.h"

namespace espalier::validation {

/// The fluxes of the light that comes in.
struct Fluxes {
  double up = 0.0, down = 0.0, byPlants = 0.0, byGround = 0.0;
};

/// The largest differences of a group of comparisons.
struct Largest {
  LargestError absorbed, reflected, down, balance;

  void add(const Fluxes& fluxes, double expectedAbsorbed, double expectedReflected, double expectedDown) {
    absorbed.add(std::abs(fluxes.byPlants - expectedAbsorbed));
    reflected.add(std::abs(fluxes.up - expectedReflected));
    down.add(std::abs(fluxes.down - expectedDown));
    balance.add(std::abs(fluxes.byPlants + fluxes.up + fluxes.byGround - 1.0));
  }
  void addTo(CaseResult& result, const std::string& what, std::optional<double> tolerance) const {
    result.rows.push_back({what + ", absorbed", absorbed.value(), tolerance, ""});
    result.rows.push_back({what + ", reflected", reflected.value(), tolerance, ""});
    result.rows.push_back({what + ", down at the ground", down.value(), tolerance, ""});
  }
};

/// The largest balance as a row.
inline void addBalance(CaseResult& result, const std::vector<Largest>& parts) {
  LargestError balance;
  for (const Largest& part : parts) {
    balance.add(part.balance.value());
  }
  result.rows.push_back({"balance of light", balance.value(), 1e-3, ""});
}

/// Leaves and ground in one band; by default both black.
struct Band {
  double rho = 0.0, tau = 0.0, ground = 0.0;
};

/// A process takes at most so many.
inline constexpr std::size_t kMostBands = 16;

/// A direction of the sun, or the mean of `azimuths` directions evenly around the vertical; zenith below 0: a sky.
/// Degrees.
struct Light {
  double zenith = -1.0;
  double azimuth = 30.0;
  int azimuths = 1;
  std::string sky = "uniform";  // or "overcast"

  [[nodiscard]] core::Vec3 direction() const {
    const double angle = zenith * std::numbers::pi / 180.0;
    const double turn = azimuth * std::numbers::pi / 180.0;
    return {core::sin(angle) * core::cos(turn), core::cos(angle), core::sin(angle) * core::sin(turn)};
  }
};

/// The light of a table: "uniform", "overcast", or a zenith angle in degrees.
[[nodiscard]] Light lightOf(const std::string& zenith);

/// Numbers as a JSON list.
[[nodiscard]] std::string listOf(const std::vector<double>& numbers);

/// The fluxes of all bands in a square stand from 0 to `side` that repeats itself, by the process `light`, over a
/// ground of so many squares along each side. A quick case has one thread (case_runs.h).
[[nodiscard]] std::vector<Fluxes> rayFluxes(const environment::Canopy& canopy, double side,
                                            const std::vector<Band>& bands, const Light& light, int directions,
                                            int groundCells, int threads = 2);

/// A box of voxels with leaves, which repeats itself.
struct Voxels {
  std::array<int, 3> cells{};
  double side = 1.0;
  std::vector<double> densities;
  std::string leafAngles = "spherical";
};

/// The fluxes of all bands by the process `light-voxels`.
[[nodiscard]] std::vector<Fluxes> voxelFluxes(const Voxels& voxels, const std::vector<Band>& bands, const Light& light);

/// Part of the light that comes past black leaves to the ground, by rays from sensors there.
[[nodiscard]] double passedVoxels(const Voxels& voxels, const Light& light);

}  // namespace espalier::validation
