// Benchmarks of light: layers of leaves, view factors, the sun. Lengths in m, light as parts of what comes in.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "clients/espalier/validation/canopy_fluxes.h"
#include "clients/espalier/validation/closed_forms.h"
#include "clients/espalier/validation/process_run.h"
#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/validation.h"
#include "environment/base/number_text.h"
#include "environment/light/sun_position.h"

namespace espalier::validation {

namespace {

using core::Vec3;
using environment::Canopy;
using environment::numberText;
using std::numbers::pi;

// ---- layers

/// A layer with scattering, and the fluxes that it must have.
struct LayerRow {
  double leafAreaIndex = 0.0;
  std::string zenith;
  Band band;
  LayerFluxes exact;
};

/// Rows in voxels and with leaves at random.
CaseResult layers(const std::vector<LayerRow>& rows, bool isHorizontal) {
  CaseResult result;
  Largest voxels;
  Largest rays;
  const auto add = [](Largest& largest, const Fluxes& fluxes, const LayerRow& row) {
    largest.add(fluxes, row.exact.absorbed, row.exact.reflected, row.exact.down);
  };
  std::map<std::pair<double, std::string>, std::vector<LayerRow>> groups;  // by leaf area index and light
  for (const LayerRow& row : rows) {
    add(voxels,
        voxelFluxes({1, 40, 1}, std::vector<double>(40, row.leafAreaIndex / 40.0),
                    isHorizontal ? "horizontal" : "spherical", row.band, lightOf(row.zenith)),
        row);
    groups[{row.leafAreaIndex, row.zenith}].push_back(row);
  }
  for (const auto& [key, group] : groups) {
    constexpr double kSide = 10.0;
    constexpr std::size_t kMostBands = 16;
    Canopy canopy;
    canopy.layer(kSide, 10.0, key.first, 40'000, isHorizontal);
    for (std::size_t begin = 0; begin < group.size(); begin += kMostBands) {
      const std::size_t end = std::min(begin + kMostBands, group.size());
      std::vector<Band> bands;
      for (std::size_t i = begin; i < end; ++i) {
        bands.push_back(group[i].band);
      }
      const std::vector<Fluxes> fluxes = rayFluxes(canopy, kSide, bands, lightOf(key.second), 32, 16);
      for (std::size_t i = begin; i < end; ++i) {
        add(rays, fluxes[i - begin], group[i]);
      }
    }
  }
  voxels.addTo(result, "light-voxels", 0.005);
  rays.addTo(result, "light, 40000 leaves", 0.010);
  addBalance(result, {voxels, rays});
  return result;
}

CaseResult horizontalLayers(const Data&) {
  std::vector<LayerRow> rows;
  for (const double index : {0.5, 2.0, 5.0}) {
    // horizontal leaves scatter light of any direction in the same way
    for (const std::string zenith : {"uniform", "27.4643", "60"}) {
      for (const auto& [rho, tau] : {std::pair{0.0735, 0.0566}, {0.3912, 0.4146}, {0.5, 0.5}}) {
        for (const double ground : {0.0, 0.2, 1.0}) {
          rows.push_back({index, zenith, {rho, tau, ground}, horizontalLayer(index, rho, tau, ground)});
        }
      }
    }
  }
  return layers(rows, true);
}

CaseResult sphericalLayers(const Data& data) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "light_spherical.tsv", result.missing);
  if (!table) {
    return result;
  }
  std::vector<LayerRow> rows;
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const auto number = [&](const char* column) { return table->number(row, column); };
    rows.push_back({number("lai"),
                    table->text(row, "zenith"),
                    {number("rho"), number("tau"), number("ground")},
                    {number("reflected"), number("absorbed"), number("down_at_ground")}});
  }
  return layers(rows, false);
}

CaseResult blackLayers(const Data&) {
  CaseResult result;
  LargestError beams;
  LargestError skies;
  const auto compare = [&](const std::string& leaves, double ratio, const std::string& light, double index) {
    const bool isBeam = light.starts_with("zenith");
    std::string text = R"({"voxelSize":1,"position":[0,0,0],"periodic":true,"gridSize":[1,10,1],"leafAngles":")" +
                       leaves + R"(","ellipsoidRatio":)" + numberText(ratio) + R"(,"leafAreaDensity":)" +
                       listOf(std::vector<double>(10, index / 10.0));
    if (isBeam) {
      const Vec3 sun = Light{std::stod(light.substr(6))}.direction();
      text += R"(,"directions":[)" + listOf({sun.x, sun.y, sun.z, 1.0}) + "]}";
    } else {
      text += R"(,"zenithAngles":32,"azimuthAngles":2,"sky":")" + light + R"("})";
    }
    const double passed = runProcess("light-voxels", text, queriesAt({{}}, {0.0})).replies.values[0];
    const double error = std::abs(passed - passedBlackLeaves(leaves, ratio, light, index));
    (isBeam ? beams : skies).add(error);
  };
  for (const double index : {1.0, 3.0}) {
    for (const std::string leaves : {"horizontal", "vertical", "spherical", "planophile", "erectophile", "plagiophile",
                                     "extremophile", "uniform"}) {
      for (const std::string light : {"zenith0", "zenith30", "zenith60", "zenith75"}) {
        compare(leaves, 1.0, light, index);
      }
    }
    for (const double ratio : {0.5, 2.0}) {
      for (const std::string light : {"zenith0", "zenith30", "zenith60", "zenith75", "uniform", "overcast"}) {
        compare("ellipsoidal", ratio, light, index);
      }
    }
    for (const std::string leaves : {"horizontal", "vertical", "spherical"}) {
      compare(leaves, 1.0, "uniform", index);
      compare(leaves, 1.0, "overcast", index);
    }
  }
  result.rows = {{"light-voxels, beams", beams.value(), 1e-6, ""}, {"light-voxels, skies", skies.value(), 2e-3, ""}};
  return result;
}

// ---- view factors

/// What a black receiver gets of the light that a sheet gives off, as a part: the sheet lets all light through and
/// gives off as much on its other side as comes in, evenly. Two million rays from each sheet.
double factorBetween(const Canopy& canopy, std::size_t sheets, double power) {
  const std::size_t rays = 2'097'152 / sheets;
  turtle::QueryBatch queries = queriesAt(std::vector<Vec3>(canopy.count()), {0.0, 0.0});
  queries.geometry = canopy.geometry();
  const auto replies = runProcess("light",
                                  R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"bounces":1,)"
                                  R"("materials":[[0,0,1],[1,0,0],[2,1,0]],"directions":)" +
                                      std::to_string(rays) + "}",
                                  queries)
                           .replies.values;
  double sum = 0.0;
  for (std::size_t k = 2 * sheets + 1; k < replies.size(); k += 2) {
    sum += replies[k];
  }
  return sum / power;
}

/// Two surfaces, the first one the sheet; and the area of that.
struct Pair {
  Canopy canopy;
  double area = 0.0;
};
Pair pairOf(const std::string& kind, double p1, double p2, double p3) {
  Pair pair;
  if (kind == "rectangles") {
    // the upper one is the sheet, lit from straight above; the lower one the receiver
    pair.canopy.rectangle({0, p3, 0}, {0, 0, p2}, {p1, 0, 0}, 0);
    pair.canopy.rectangle({0, 0, 0}, {0, 0, p2}, {p1, 0, 0}, 1);
    pair.area = p1 * p2;
  } else if (kind == "corner") {
    // the lying one reflects the light from straight above, the other stands at its edge
    pair.canopy.rectangle({0, 0, 0}, {0, 0, p3}, {p1, 0, 0}, 2);
    pair.canopy.rectangle({0, 0, 0}, {0, 0, p3}, {0, p2, 0}, 1);
    pair.area = p1 * p3;
  } else {
    // polygons of so many sides that their area is that of the disc
    constexpr int kSides = 256;
    const auto disc = [&](double radius, double height, std::uint8_t colour) {
      const double wider = std::sqrt(2.0 * pi / kSides / core::sin(2.0 * pi / kSides));
      const auto corner = [&](int k) {
        const double angle = 2.0 * pi * k / kSides;
        return Vec3{radius * wider * core::cos(angle), height, radius * wider * core::sin(angle)};
      };
      for (int k = 0; k < kSides; ++k) {
        pair.canopy.triangle({0, height, 0}, corner(k + 1), corner(k), colour);
      }
    };
    disc(p1, p3, 0);
    disc(p2, 0.0, 1);
    pair.area = pi * p1 * p1;
  }
  return pair;
}

CaseResult viewFactors(const Data&) {
  struct Arrangement {
    const char* kind;
    double p1, p2, p3;
  };
  CaseResult result;
  for (const auto& [kind, p1, p2, p3] :
       {Arrangement{"discs", 1, 1, 1}, Arrangement{"discs", 1, 0.5, 0.75}, Arrangement{"discs", 0.5, 2, 1},
        Arrangement{"rectangles", 1, 1, 1}, Arrangement{"rectangles", 1, 2, 0.5}, Arrangement{"rectangles", 1, 1, 3},
        Arrangement{"corner", 1, 1, 1}, Arrangement{"corner", 1, 2, 1}, Arrangement{"corner", 2, 1, 3}}) {
    // a larger receiver would have light past the sheet: F₁₂ A₁ = F₂₁ A₂
    const bool isTurned = std::string(kind) == "discs" && p2 > p1;
    const Pair pair = isTurned ? pairOf(kind, p2, p1, p3) : pairOf(kind, p1, p2, p3);
    const double own = factorBetween(pair.canopy, pair.canopy.count() / 2, pair.area);
    const double factor = isTurned ? own * p2 * p2 / (p1 * p1) : own;
    result.rows.push_back(
        {std::string(kind) + " " + numberText(p1) + " " + numberText(p2) + " " + numberText(p3) + ", relative",
         std::abs(factor / viewFactor(kind, p1, p2, p3) - 1.0), 0.005, ""});
  }
  return result;
}

// ---- the sun

CaseResult sunPositions(const Data& data) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "sun_positions.tsv", result.missing);
  if (!table) {
    return result;
  }
  LargestError error;
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const environment::SunPosition sun =
        environment::sunPosition(environment::julianDayOf(table->text(row, "universal_time")).value_or(NAN),
                                 table->number(row, "latitude"), table->number(row, "longitude"));
    error.add(std::abs(sun.elevationRadians * 180.0 / pi - table->number(row, "elevation")));
    error.add(std::abs(sun.azimuthRadians * 180.0 / pi - table->number(row, "azimuth")));
  }
  result.rows.push_back({"azimuth and elevation, degrees", error.value(), 0.02, ""});
  return result;
}

}  // namespace

std::span<const Case> lightCases() {
  static constexpr std::array<Case, 5> kCases{
      {{"layers", "Black leaves in layers: Beer's law, Campbell 1986", true, blackLayers},
       {"layers-horizontal", "Horizontal leaves that scatter, over a ground: closed form", false, horizontalLayers},
       {"layers-spherical", "Spherical leaves that scatter, over a ground: discrete ordinates", false, sphericalLayers},
       {"view-factors", "View factors of squares, rectangles and discs: closed forms", true, viewFactors},
       {"sun", "Positions of the sun after Reda & Andreas 2004", true, sunPositions}}};
  return kCases;
}

}  // namespace espalier::validation
