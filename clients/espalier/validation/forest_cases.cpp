// Open forests of RAMI4PILPS (Widlowski et al. 2011). Lengths in m, light as parts of what comes in.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/// Crowns in voxels, so many along a metre. The leaves of a crown are even in the voxels whose middle is in it, so its
/// surface stays sharp. With the mean density of voxels of 1 m at the surface 0.025 less light passes 398 crowns than
/// passes spheres.
Voxels voxelsOf(const std::vector<Vec3>& crowns, int voxelsInMetre) {
  constexpr int kHighest = 16;  // m
  const double side = 1.0 / voxelsInMetre;
  const int width = static_cast<int>(kPlot) * voxelsInMetre;
  const int layers = kHighest * voxelsInMetre;
  const int reach = (static_cast<int>(kRadius) + 1) * voxelsInMetre;
  const auto whole = static_cast<std::size_t>(width);
  Voxels voxels{{width, layers, width},
                side,
                std::vector<double>(whole * whole * static_cast<std::size_t>(layers), 0.0),
                "spherical"};
  const auto inPlot = [width](int cell) { return (cell % width + width) % width; };
  for (const Vec3& crown : crowns) {
    const Vec3 centre = crown * (1.0 / side);
    std::vector<std::size_t> inside;
    const int x = static_cast<int>(std::floor(centre.x));
    const int y = static_cast<int>(std::floor(centre.y));
    const int z = static_cast<int>(std::floor(centre.z));
    for (int k = z - reach; k <= z + reach; ++k) {
      for (int j = std::max(y - reach, 0); j <= std::min(y + reach, layers - 1); ++j) {
        for (int i = x - reach; i <= x + reach; ++i) {
          if (core::length(Vec3{i + 0.5, j + 0.5, k + 0.5} - centre) * side < kRadius) {
            inside.push_back(static_cast<std::size_t>((inPlot(k) * layers + j) * width + inPlot(i)));
          }
        }
      }
    }
    for (const std::size_t voxel : inside) {
      voxels.densities[voxel] += kLeafArea / (static_cast<double>(inside.size()) * side * side * side);
    }
  }
  return voxels;
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

/// The light of the rows of a group. The Monte Carlo run on these crowns has a sun of any azimuth.
Light lightOfGroup(const ForestRows& group) {
  Light light = lightOf(group.zenith);
  light.azimuths = 16;
  return light;
}

/// The fluxes of all rows, and last those of black leaves over a black ground. Squares of the ground must be small
/// against the gaps between crowns: over snow, squares of 16 m make the crowns absorb 0.005 of the light too much.
std::vector<Fluxes> fluxesOf(const Canopy& canopy, const ForestRows& group, bool isQuick) {
  const int groundCells = isQuick ? 50 : 125;  // of 5 or 2 m
  std::vector<Band> bands = group.bands;
  bands.emplace_back();
  return rayFluxes(canopy, kPlot, bands, lightOfGroup(group), 16, groundCells, isQuick ? 1 : 2);
}

/// The results of a process for the forests of a density under one light, beside the published fluxes and the Monte
/// Carlo run.
struct Comparison {
  std::string zenith;              // as in the table
  Largest published, own;          // own: the Monte Carlo run on the same crowns
  double unscattered = NAN;        // light past black leaves, of the Monte Carlo run
  double unscatteredInFine = NAN;  // the same in voxels of half the size

  Comparison(const ReferenceTable& table, const ForestRows& group, const std::vector<Fluxes>& fluxes)
      : zenith(group.zenith) {
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      const auto number = [&](const char* column) { return table.number(group.rows[i], column); };
      published.add(fluxes[i], number("absorbed"), number("reflected"), number("down_at_ground"));
      own.add(fluxes[i], number("mc_absorbed"), number("mc_reflected"), number("mc_down"));
    }
  }
};

/// How far the fluxes of a process may be off; nothing: reported only.
struct Tolerances {
  std::optional<double> published, publishedOfLowSun, own, ownOfLowSun, unscattered, unscatteredOfLowSun;
};

/// The rows of all lights, the high sun first, and the balance.
void addComparisons(std::vector<Comparison> comparisons, const Tolerances& tolerances, CaseResult& result) {
  std::sort(comparisons.begin(), comparisons.end(), [](const Comparison& a, const Comparison& b) {
    return std::pair(isLow(a.zenith), a.zenith) < std::pair(isLow(b.zenith), b.zenith);
  });
  std::vector<Largest> balances;
  for (const Comparison& one : comparisons) {
    const bool isLowSun = isLow(one.zenith);
    const std::string name = one.zenith == "uniform" ? "uniform sky"
                             : isLowSun              ? "83.5 degrees, mean of 16 azimuths"
                                                     : one.zenith.substr(0, 2) + " degrees";
    one.published.addTo(result, name + ", published", isLowSun ? tolerances.publishedOfLowSun : tolerances.published);
    one.own.addTo(result, name + ", Monte Carlo on these crowns", isLowSun ? tolerances.ownOfLowSun : tolerances.own);
    result.rows.push_back({name + ", past black leaves", one.unscattered,
                           isLowSun ? tolerances.unscatteredOfLowSun : tolerances.unscattered, ""});
    if (!std::isnan(one.unscatteredInFine)) {
      result.rows.push_back({name + ", past black leaves, voxels of 0.5 m", one.unscatteredInFine,
                             isLowSun ? std::nullopt : std::optional(0.010), ""});
    }
    balances.push_back(one.published);
  }
  addBalance(result, balances);
}

/// The light that crowns absorb, in the order of the table.
class AbsorbedCurves {
 public:
  explicit AbsorbedCurves(const std::string& spheres)
      : own_{spheres + " crowns", false, {}},
        published_{spheres + " crowns, published", true, {}},
        monteCarlo_{spheres + " crowns, Monte Carlo on the same crowns", true, {}} {}

  void add(const ReferenceTable& table, const ForestRows& group, const std::vector<Fluxes>& fluxes) {
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      const auto across = static_cast<double>(group.rows[i]);
      own_.points.emplace_back(across, fluxes[i].byPlants);
      published_.points.emplace_back(across, table.number(group.rows[i], "absorbed"));
      monteCarlo_.points.emplace_back(across, table.number(group.rows[i], "mc_absorbed"));
    }
  }
  void addTo(CaseResult& result) {
    result.across = "row of the table";
    result.up = "absorbed part of the light";
    for (Curve* curve : {&own_, &published_, &monteCarlo_}) {
      std::sort(curve->points.begin(), curve->points.end());
      result.curves.push_back(std::move(*curve));
    }
  }

 private:
  Curve own_, published_, monteCarlo_;
};

/// Forests of so many crowns in rays; with a zenith angle only that.
CaseResult openForest(const Data& data, const std::string& spheres, const std::string& onlyZenith) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "rami4pilps.tsv", result.missing);
  const auto places = ReferenceTable::read(data, "rami_crowns_" + spheres + ".tsv", result.missing);
  if (!table || !places) {
    return result;
  }
  const bool isWhole = onlyZenith.empty();
  // of a crown; with 2000 the light that 239 crowns absorb differs by 0.0104
  const Canopy canopy = leavesOf(crownsOf(*places), isWhole ? 5000 : 2000);
  std::vector<Comparison> comparisons;
  AbsorbedCurves curves(spheres);
  for (const ForestRows& group : forestRows(*table, spheres)) {
    if (!isWhole && group.zenith != onlyZenith) {
      continue;
    }
    const std::vector<Fluxes> fluxes = fluxesOf(canopy, group, !isWhole);
    comparisons.emplace_back(*table, group, fluxes);
    comparisons.back().unscattered = std::abs(fluxes.back().down - table->number(group.rows.front(), "mc_unscattered"));
    curves.add(*table, group, fluxes);
  }
  addComparisons(std::move(comparisons),
                 {.published = 0.010,
                  .publishedOfLowSun = std::nullopt,
                  .own = 0.006,
                  .ownOfLowSun = 0.012,
                  .unscattered = 0.006,
                  .unscatteredOfLowSun = 0.012},
                 result);
  curves.addTo(result);
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

/// Forests of so many crowns in voxels.
CaseResult openForestInVoxels(const Data& data, const std::string& spheres) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "rami4pilps.tsv", result.missing);
  const auto places = ReferenceTable::read(data, "rami_crowns_" + spheres + ".tsv", result.missing);
  if (!table || !places) {
    return result;
  }
  const Voxels voxels = voxelsOf(crownsOf(*places), 1);
  const Voxels fine = voxelsOf(crownsOf(*places), 2);
  std::vector<Comparison> comparisons;
  AbsorbedCurves curves(spheres);
  for (const ForestRows& group : forestRows(*table, spheres)) {
    const Light light = lightOfGroup(group);
    const std::vector<Fluxes> fluxes = voxelFluxes(voxels, group.bands, light);
    comparisons.emplace_back(*table, group, fluxes);
    curves.add(*table, group, fluxes);
    const double passed = table->number(group.rows.front(), "mc_unscattered");
    comparisons.back().unscattered = std::abs(passedVoxels(voxels, light) - passed);
    comparisons.back().unscatteredInFine = std::abs(passedVoxels(fine, light) - passed);
  }
  addComparisons(std::move(comparisons),
                 {.published = 0.020,
                  .publishedOfLowSun = std::nullopt,
                  .own = 0.020,
                  .ownOfLowSun = 0.020,
                  .unscattered = std::nullopt,
                  .unscatteredOfLowSun = std::nullopt},
                 result);
  curves.addTo(result);
  return result;
}

CaseResult voxels80(const Data& data) {
  return openForestInVoxels(data, "80");
}
CaseResult voxels239(const Data& data) {
  return openForestInVoxels(data, "239");
}
CaseResult voxels398(const Data& data) {
  return openForestInVoxels(data, "398");
}

}  // namespace

std::span<const Case> forestCases() {
  static constexpr std::array<Case, 7> kCases{
      {{"rami-quick", "RAMI4PILPS, 80 crowns, sun at 60 degrees, light (Widlowski et al. 2011)", true, openForestQuick},
       {"rami-80", "RAMI4PILPS, 80 crowns, light (Widlowski et al. 2011)", false, openForest80},
       {"rami-239", "RAMI4PILPS, 239 crowns, light (Widlowski et al. 2011)", false, openForest239},
       {"rami-398", "RAMI4PILPS, 398 crowns, light (Widlowski et al. 2011)", false, openForest398},
       {"rami-voxels-80", "RAMI4PILPS, 80 crowns, light-voxels (Widlowski et al. 2011)", false, voxels80},
       {"rami-voxels-239", "RAMI4PILPS, 239 crowns, light-voxels (Widlowski et al. 2011)", false, voxels239},
       {"rami-voxels-398", "RAMI4PILPS, 398 crowns, light-voxels (Widlowski et al. 2011)", false, voxels398}}};
  return kCases;
}

}  // namespace espalier::validation
