// Open forests of RAMI4PILPS (Widlowski et al. 2011). Lengths in m, light as parts of what comes in.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "clients/espalier/validation/canopy_fluxes.h"
#include "clients/espalier/validation/reference_table.h"

namespace espalier::validation {

namespace {

using core::Vec3;
using environment::Canopy;
using std::numbers::pi;

constexpr double kPlot = 250.0;
constexpr double kRadius = 5.0;
constexpr double kDensity = 0.75;                                                      // m² of leaves in a cubic metre
constexpr double kLeafArea = kDensity * 4.0 / 3.0 * pi * kRadius * kRadius * kRadius;  // of a crown

/// The crowns of a table: x, y, height.
std::vector<Vec3> crownsOf(const ReferenceTable& table) {
  std::vector<Vec3> crowns;
  for (std::size_t row = 0; row < table.rowCount(); ++row) {
    crowns.push_back({table.number(row, "x"), table.number(row, "height"), table.number(row, "y")});
  }
  return crowns;
}

Canopy leavesOf(const std::vector<Vec3>& crowns, std::size_t leaves) {
  Canopy canopy;
  for (const Vec3& crown : crowns) {
    canopy.crown(crown, kRadius, kLeafArea, leaves);
  }
  return canopy;
}

/// Leaf area densities of voxels of 1 m. The leaves of a crown are even in the voxels whose middle is in it, so its
/// surface stays sharp. With the mean density of voxels at the surface 0.025 less light passes 398 crowns than passes
/// spheres, against 0.013.
std::vector<double> densitiesOf(const std::vector<Vec3>& crowns, int side, int layers) {
  constexpr int kReach = static_cast<int>(kRadius) + 1;
  std::vector<double> densities(static_cast<std::size_t>(side) * static_cast<std::size_t>(side * layers), 0.0);
  const auto inPlot = [side](int cell) { return (cell % side + side) % side; };
  for (const Vec3& crown : crowns) {
    std::vector<std::size_t> inside;
    const int x = static_cast<int>(std::floor(crown.x));
    const int y = static_cast<int>(std::floor(crown.y));
    const int z = static_cast<int>(std::floor(crown.z));
    for (int k = z - kReach; k <= z + kReach; ++k) {
      for (int j = std::max(y - kReach, 0); j <= std::min(y + kReach, layers - 1); ++j) {
        for (int i = x - kReach; i <= x + kReach; ++i) {
          if (core::length(Vec3{i + 0.5, j + 0.5, k + 0.5} - crown) < kRadius) {
            inside.push_back(static_cast<std::size_t>((inPlot(k) * layers + j) * side + inPlot(i)));
          }
        }
      }
    }
    for (const std::size_t voxel : inside) {
      densities[voxel] += kLeafArea / static_cast<double>(inside.size());
    }
  }
  return densities;
}

/// Rows of rami4pilps.tsv of one density and one light.
struct ForestRows {
  std::string zenith;  // as in the table
  std::vector<std::size_t> rows;
  std::vector<Band> bands;
};

std::vector<ForestRows> forestRows(const ReferenceTable& table, const std::string& spheres) {
  std::vector<ForestRows> groups;
  for (std::size_t row = 0; row < table.rowCount(); ++row) {
    if (table.text(row, "spheres") != spheres) {
      continue;
    }
    const std::string& zenith = table.text(row, "zenith");
    auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& one) { return one.zenith == zenith; });
    if (group == groups.end()) {
      group = groups.insert(groups.end(), ForestRows{zenith, {}, {}});
    }
    group->rows.push_back(row);
    group->bands.push_back({table.number(row, "rho"), table.number(row, "tau"), table.number(row, "ground")});
  }
  return groups;
}

bool isLow(const std::string& zenith) {
  return zenith.starts_with("83");
}

/// The fluxes of all rows. The Monte Carlo run on these crowns has a sun of any azimuth. Squares of the ground must be
/// small against the gaps between crowns: over snow, squares of 16 m make the crowns absorb 0.005 of the light too
/// much.
std::vector<Fluxes> fluxesOf(const Canopy& canopy, const ForestRows& group, bool isQuick) {
  constexpr int kAzimuths = 16;
  const int groundCells = isQuick ? 50 : 125;  // of 5 or 2 m
  Light light = lightOf(group.zenith);
  light.azimuths = kAzimuths;
  return rayFluxes(canopy, kPlot, group.bands, light, 16, groundCells);
}

/// Forests of so many crowns in rays; with a zenith angle only that.
CaseResult openForest(const Data& data, const std::string& spheres, const std::string& onlyZenith) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "rami4pilps.tsv", result.missing);
  const auto places = ReferenceTable::read(data, "rami_crowns_" + spheres + ".tsv", result.missing);
  if (!table || !places) {
    return result;
  }
  // of a crown; with 2000 the light that 239 crowns absorb differs by 0.0104
  const std::size_t leaves = onlyZenith.empty() ? 5000 : 2000;
  const Canopy canopy = leavesOf(crownsOf(*places), leaves);
  Largest high;
  Largest highToOwn;
  Largest low;
  Largest lowToOwn;
  // absorbed light in the order of the table
  Curve absorbed{spheres + " crowns", false, {}};
  Curve published{spheres + " crowns, published", true, {}};
  for (const ForestRows& group : forestRows(*table, spheres)) {
    if (!onlyZenith.empty() && group.zenith != onlyZenith) {
      continue;
    }
    const bool isLowSun = isLow(group.zenith);
    const std::vector<Fluxes> fluxes = fluxesOf(canopy, group, !onlyZenith.empty());
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      const std::size_t row = group.rows[i];
      const auto number = [&](const char* column) { return table->number(row, column); };
      absorbed.points.emplace_back(static_cast<double>(row), fluxes[i].byPlants);
      published.points.emplace_back(static_cast<double>(row), number("absorbed"));
      (isLowSun ? low : high).add(fluxes[i], number("absorbed"), number("reflected"), number("down_at_ground"));
      (isLowSun ? lowToOwn : highToOwn)
          .add(fluxes[i], number("mc_absorbed"), number("mc_reflected"), number("mc_down"));
    }
  }
  high.addTo(result,
             onlyZenith.empty() ? "27 and 60 degrees and diffuse, published" : onlyZenith + " degrees, published",
             0.010);
  highToOwn.addTo(result, "the same, Monte Carlo on these crowns", 0.006);
  if (onlyZenith.empty()) {
    lowToOwn.addTo(result, "83.5 degrees, mean of 16 azimuths, Monte Carlo on these crowns", 0.012);
    low.addTo(result, "the same, published", std::nullopt);
    result.across = "row of the table";
    result.up = "absorbed part of the light";
    for (Curve* curve : {&absorbed, &published}) {
      std::sort(curve->points.begin(), curve->points.end());
      result.curves.push_back(std::move(*curve));
    }
  }
  addBalance(result, onlyZenith.empty() ? std::vector{high, low} : std::vector{high});
  return result;
}

CaseResult openForestQuick(const Data& data) {
  return openForest(data, "80", "60");
}
CaseResult openForest80(const Data& data) {
  return openForest(data, "80", "");
}
CaseResult openForest239(const Data& data) {
  return openForest(data, "239", "");
}
CaseResult openForest398(const Data& data) {
  return openForest(data, "398", "");
}

CaseResult openForestsInVoxels(const Data& data) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "rami4pilps.tsv", result.missing);
  Largest voxels;
  bool hasCrowns = false;
  for (const std::string spheres : {"80", "239", "398"}) {
    const auto places = ReferenceTable::read(data, "rami_crowns_" + spheres + ".tsv", result.missing);
    if (!table || !places) {
      continue;
    }
    hasCrowns = true;
    const std::vector<double> densities = densitiesOf(crownsOf(*places), static_cast<int>(kPlot), 16);
    for (const ForestRows& group : forestRows(*table, spheres)) {
      for (std::size_t i = 0; i < group.rows.size() && !isLow(group.zenith); ++i) {
        const auto number = [&](const char* column) { return table->number(group.rows[i], column); };
        voxels.add(voxelFluxes({250, 16, 250}, densities, "spherical", group.bands[i], lightOf(group.zenith)),
                   number("absorbed"), number("reflected"), number("down_at_ground"));
      }
    }
  }
  if (!hasCrowns) {
    return result;
  }
  voxels.addTo(result, "27 and 60 degrees and diffuse, published", 0.020);
  addBalance(result, {voxels});
  return result;
}

}  // namespace

std::span<const Case> forestCases() {
  static constexpr std::array<Case, 5> kCases{
      {{"rami-quick", "RAMI4PILPS, 80 crowns, sun at 60 degrees, light (Widlowski et al. 2011)", true, openForestQuick},
       {"rami-80", "RAMI4PILPS, 80 crowns, light (Widlowski et al. 2011)", false, openForest80},
       {"rami-239", "RAMI4PILPS, 239 crowns, light (Widlowski et al. 2011)", false, openForest239},
       {"rami-398", "RAMI4PILPS, 398 crowns, light (Widlowski et al. 2011)", false, openForest398},
       {"rami-voxels", "RAMI4PILPS, all crowns, light-voxels (Widlowski et al. 2011)", false, openForestsInVoxels}}};
  return kCases;
}

}  // namespace espalier::validation
