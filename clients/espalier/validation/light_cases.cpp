// Benchmarks of light in canopies: open forests of RAMI4PILPS (Widlowski et al. 2011), layers of leaves, view factors.
// Lengths in m, light as parts of what comes in.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "clients/espalier/validation/canopy.h"
#include "clients/espalier/validation/process_run.h"
#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/validation.h"
#include "engine/turtle/field.h"
#include "environment/base/number_text.h"
#include "environment/light/sun_position.h"

namespace espalier::validation {

namespace {

using core::Vec3;
using environment::numberText;
using std::numbers::pi;

/// What becomes of the light that comes in.
struct Fluxes {
  double up = 0.0, down = 0.0, byPlants = 0.0, byGround = 0.0;
};

/// The largest differences of a group of comparisons.
struct Largest {
  double absorbed = 0.0, reflected = 0.0, down = 0.0, balance = 0.0;

  void add(const Fluxes& fluxes, double expectedAbsorbed, double expectedReflected, double expectedDown) {
    absorbed = std::max(absorbed, std::abs(fluxes.byPlants - expectedAbsorbed));
    reflected = std::max(reflected, std::abs(fluxes.up - expectedReflected));
    down = std::max(down, std::abs(fluxes.down - expectedDown));
    balance = std::max(balance, std::abs(fluxes.byPlants + fluxes.up + fluxes.byGround - 1.0));
  }
  void addTo(CaseResult& result, const std::string& what, std::optional<double> tolerance) const {
    result.rows.push_back({what + ", absorbed", absorbed, tolerance, ""});
    result.rows.push_back({what + ", reflected", reflected, tolerance, ""});
    result.rows.push_back({what + ", down at the ground", down, tolerance, ""});
  }
};

/// Leaves and ground in one band.
struct Band {
  double rho = 0.0, tau = 0.0, ground = 0.0;
};

/// A direction of the sun; zenith 0: a uniform sky. Degrees.
struct Light {
  double zenith = 0.0;
  double azimuth = 30.0;

  [[nodiscard]] Vec3 direction() const {
    const double angle = zenith * pi / 180.0;
    const double turn = azimuth * pi / 180.0;
    return {core::sin(angle) * core::cos(turn), core::cos(angle), core::sin(angle) * core::sin(turn)};
  }
};

std::string listOf(const std::vector<double>& numbers) {
  std::string list;
  for (const double number : numbers) {
    list += (list.empty() ? "" : ",") + numberText(number);
  }
  return "[" + list + "]";
}

/// The fluxes of all bands in a stand that repeats itself, by the process `light`.
std::vector<Fluxes> rayFluxes(const Canopy& canopy, double side, const std::vector<Band>& bands, const Light& light,
                              int directions) {
  std::vector<double> ones;
  std::vector<double> rho;
  std::vector<double> tau;
  std::vector<double> ground;
  for (const Band& band : bands) {
    ones.push_back(1.0);
    rho.push_back(band.rho);
    tau.push_back(band.tau);
    ground.push_back(band.ground);
  }
  std::string text = R"({"sensor":"fluxes","remainder":1e-4,"ground":true,"plot":[0,)" + numberText(side) + ",0," +
                     numberText(side) + R"(],"directions":)" + std::to_string(directions) + R"(,"bands":)" +
                     listOf(ones) + R"(,"reflectance":)" + listOf(rho) + R"(,"transmittance":)" + listOf(tau) +
                     R"(,"groundReflectance":)" + listOf(ground);
  if (light.zenith > 0.0) {
    const Vec3 sun = light.direction();
    text += R"(,"diffuseIrradiance":0,"sun":"direction","directIrradiance":)" + numberText(1.0 / sun.y) +
            R"(,"sunDirection":)" + listOf({sun.x, sun.y, sun.z}) + "}";
  } else {
    text += R"(,"sky":"uniform","diffuseIrradiance":1})";
  }
  // a sensor: a query before no organ
  turtle::QueryBatch queries = queriesAt({{}}, std::vector<double>(4 * bands.size(), 0.0));
  queries.module.front() = 2 * canopy.count() + 8;
  queries.geometry = canopy.geometry();
  const auto values = runProcess("light", text, queries).replies.values;
  std::vector<Fluxes> fluxes;
  for (std::size_t k = 0; k < values.size(); k += 4) {
    fluxes.push_back({values[k], values[k + 1], values[k + 2], values[k + 3]});
  }
  return fluxes;
}

/// The same of a box of voxels of side 1, by the process `light-voxels`.
Fluxes voxelFluxes(const std::array<int, 3>& cells, const std::vector<double>& densities, const std::string& leafAngles,
                   const Band& band, const Light& light) {
  std::string text =
      R"({"voxelSize":1,"position":[0,0,0],"periodic":true,"scattering":true,"gridSize":)" +
      listOf({static_cast<double>(cells[0]), static_cast<double>(cells[1]), static_cast<double>(cells[2])}) +
      R"(,"leafAngles":")" + leafAngles + R"(","reflectance":)" + numberText(band.rho) + R"(,"transmittance":)" +
      numberText(band.tau) + R"(,"groundReflectance":)" + numberText(band.ground) + R"(,"leafAreaDensity":)" +
      listOf(densities);
  if (light.zenith > 0.0) {
    const Vec3 sun = light.direction();
    text += R"(,"directions":[)" + listOf({sun.x, sun.y, sun.z, 1.0}) + "]}";
  } else {
    text += R"(,"sky":"uniform"})";
  }
  const auto answered = runProcess("light-voxels", text, queriesAt({{}}, {0.0}));
  std::map<std::string, double> values;
  for (const turtle::Field& field : answered.process->fields()) {
    values[field.name] = field.values.front();
  }
  return {values["leavingUp"], values["downOnGround"], values["absorbedByPlants"], values["absorbedByGround"]};
}

// ---- open forests

constexpr double kPlot = 250.0;
constexpr double kRadius = 5.0;
constexpr double kDensity = 0.75;  // m² of leaves in a cubic metre

/// The crowns of a table: x, y, height.
std::vector<Vec3> crownsOf(const ReferenceTable& table) {
  std::vector<Vec3> crowns;
  for (std::size_t row = 0; row < table.rowCount(); ++row) {
    crowns.push_back({table.number(row, "x"), table.number(row, "height"), table.number(row, "y")});
  }
  return crowns;
}

Canopy leavesOf(const std::vector<Vec3>& crowns) {
  constexpr std::size_t kLeaves = 2000;
  Canopy canopy;
  for (const Vec3& crown : crowns) {
    canopy.crown(crown, kRadius, kDensity * 4.0 / 3.0 * pi * kRadius * kRadius * kRadius, kLeaves);
  }
  return canopy;
}

/// Leaf area densities of voxels of 1 m, each sampled at 64 points.
std::vector<double> densitiesOf(const std::vector<Vec3>& crowns, int side, int layers) {
  constexpr int kPoints = 44;  // of 1/4 m, over a crown
  std::vector<double> densities(static_cast<std::size_t>(side) * static_cast<std::size_t>(side * layers), 0.0);
  const auto cell = [side](double at) {
    return static_cast<int>(std::floor(at - side * std::floor(at / side))) % side;
  };
  for (const Vec3& crown : crowns) {
    for (int i = 0; i < kPoints * kPoints * kPoints; ++i) {
      const auto offset = [](int number) { return 0.25 * (number - kPoints / 2 + 0.5); };
      const Vec3 own{offset(i % kPoints), offset(i / kPoints % kPoints), offset(i / (kPoints * kPoints))};
      if (core::length(own) < kRadius) {
        const Vec3 place = crown + own;
        const int layer = static_cast<int>(std::floor(place.y));
        densities[static_cast<std::size_t>((cell(place.z) * layers + layer) * side + cell(place.x))] += kDensity / 64.0;
      }
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

Light lightOf(const std::string& zenith) {
  return zenith == "uniform" ? Light{} : Light{std::stod(zenith)};
}
bool isLow(const std::string& zenith) {
  return zenith.starts_with("83");
}

CaseResult openForests(const Data& data, bool isWhole) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "rami4pilps.tsv", result.missing);
  if (!table) {
    return result;
  }
  Largest rays;
  Largest raysToOwn;
  Largest low;
  Largest lowToOwn;
  Largest voxels;
  for (const std::string spheres : {"80", "239", "398"}) {
    if (!isWhole && spheres != "80") {
      continue;
    }
    const auto places = ReferenceTable::read(data, "rami_crowns_" + spheres + ".tsv", result.missing);
    if (!places) {
      continue;
    }
    const std::vector<Vec3> crowns = crownsOf(*places);
    const Canopy canopy = leavesOf(crowns);
    const std::vector<double> densities = isWhole ? densitiesOf(crowns, 250, 16) : std::vector<double>{};
    for (const ForestRows& group : forestRows(*table, spheres)) {
      if (!isWhole && group.zenith != "60") {
        continue;
      }
      const bool isLowSun = isLow(group.zenith);
      const int azimuths = isLowSun ? 16 : 1;
      std::vector<Fluxes> means(group.rows.size());
      for (int k = 0; k < azimuths; ++k) {
        Light light = lightOf(group.zenith);
        light.azimuth += 360.0 * k / azimuths;
        const std::vector<Fluxes> fluxes = rayFluxes(canopy, kPlot, group.bands, light, 16);
        for (std::size_t i = 0; i < fluxes.size(); ++i) {
          means[i].up += fluxes[i].up / azimuths;
          means[i].down += fluxes[i].down / azimuths;
          means[i].byPlants += fluxes[i].byPlants / azimuths;
          means[i].byGround += fluxes[i].byGround / azimuths;
        }
      }
      for (std::size_t i = 0; i < group.rows.size(); ++i) {
        const std::size_t row = group.rows[i];
        const auto number = [&](const char* column) { return table->number(row, column); };
        (isLowSun ? low : rays).add(means[i], number("absorbed"), number("reflected"), number("down_at_ground"));
        (isLowSun ? lowToOwn : raysToOwn)
            .add(means[i], number("mc_absorbed"), number("mc_reflected"), number("mc_down"));
        if (isWhole && !isLowSun) {
          voxels.add(voxelFluxes({250, 16, 250}, densities, "spherical", group.bands[i], lightOf(group.zenith)),
                     number("absorbed"), number("reflected"), number("down_at_ground"));
        }
      }
    }
  }
  rays.addTo(result, isWhole ? "light, sun at 27 and 60 degrees and diffuse" : "light, 80 crowns, sun at 60 degrees",
             0.010);
  raysToOwn.addTo(result, "the same against Monte Carlo on these crowns", isWhole ? 0.006 : 0.010);
  result.rows.push_back({"balance of light", std::max(rays.balance, low.balance), 1e-3, ""});
  if (isWhole) {
    lowToOwn.addTo(result, "light, 83.5 degrees, Monte Carlo", 0.012);
    low.addTo(result, "light, 83.5 degrees, published", std::nullopt);
    voxels.addTo(result, "light-voxels of 1 m", 0.020);
  }
  return result;
}

CaseResult openForestsQuick(const Data& data) {
  return openForests(data, false);
}
CaseResult openForestsWhole(const Data& data) {
  return openForests(data, true);
}

// ---- layers

/// A box of 4 x 4 columns full of leaves, as layers of 1 m.
std::vector<double> fullBox(double leafAreaIndex, int layers) {
  return std::vector<double>(static_cast<std::size_t>(16 * layers), leafAreaIndex / layers);
}

/// Rows of layers with scattering, in voxels and with leaves at random.
CaseResult layers(const Data& data, const std::string& file, bool isHorizontal) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, file, result.missing);
  if (!table) {
    return result;
  }
  Largest voxels;
  Largest rays;
  std::map<std::pair<double, std::string>, std::vector<std::size_t>> groups;  // by leaf area index and light
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const auto number = [&](const char* column) { return table->number(row, column); };
    // horizontal leaves scatter light of any direction in the same way
    const std::string zenith = isHorizontal ? "uniform" : table->text(row, "zenith");
    const Band band{number("rho"), number("tau"), number("ground")};
    voxels.add(voxelFluxes({1, 40, 1}, std::vector<double>(40, number("lai") / 40.0),
                           isHorizontal ? "horizontal" : "spherical", band, lightOf(zenith)),
               number("absorbed"), number("reflected"), number("down_at_ground"));
    groups[{number("lai"), zenith}].push_back(row);
  }
  for (const auto& [key, rows] : groups) {
    constexpr double kSide = 10.0;
    const auto& [index, zenith] = key;
    Canopy canopy;
    canopy.layer(kSide, 10.0, index, 8000, isHorizontal);
    for (std::size_t begin = 0; begin < rows.size(); begin += 16) {
      std::vector<Band> bands;
      const std::size_t end = std::min(begin + 16, rows.size());
      for (std::size_t i = begin; i < end; ++i) {
        bands.push_back(
            {table->number(rows[i], "rho"), table->number(rows[i], "tau"), table->number(rows[i], "ground")});
      }
      const std::vector<Fluxes> fluxes = rayFluxes(canopy, kSide, bands, lightOf(zenith), 32);
      for (std::size_t i = begin; i < end; ++i) {
        const auto number = [&](const char* column) { return table->number(rows[i], column); };
        rays.add(fluxes[i - begin], number("absorbed"), number("reflected"), number("down_at_ground"));
      }
    }
  }
  voxels.addTo(result, "light-voxels", 0.005);
  rays.addTo(result, "light, 8000 leaves", 0.010);
  result.rows.push_back({"balance of light", std::max(voxels.balance, rays.balance), 1e-3, ""});
  return result;
}

CaseResult horizontalLayers(const Data& data) {
  return layers(data, "light_horizontal.tsv", true);
}
CaseResult sphericalLayers(const Data& data) {
  return layers(data, "light_spherical.tsv", false);
}

CaseResult blackLayers(const Data& data) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "light_layers.tsv", result.missing);
  if (!table) {
    return result;
  }
  double beams = 0.0;
  double skies = 0.0;
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const std::string& light = table->text(row, "light");
    const bool isBeam = light.starts_with("zenith");
    std::string text = R"({"voxelSize":1,"position":[0,0,0],"periodic":true,"gridSize":[1,10,1],"leafAngles":")" +
                       table->text(row, "leaves") + R"(","leafAreaDensity":)" +
                       listOf(std::vector<double>(10, table->number(row, "lai") / 10.0));
    if (!table->text(row, "ratio").empty()) {
      text += R"(,"ellipsoidRatio":)" + numberText(table->number(row, "ratio"));
    }
    if (isBeam) {
      const Vec3 sun = Light{std::stod(light.substr(6))}.direction();
      text += R"(,"directions":[)" + listOf({sun.x, sun.y, sun.z, 1.0}) + "]}";
    } else {
      text += R"(,"zenithAngles":32,"azimuthAngles":2,"sky":")" + light + R"("})";
    }
    const double passed = runProcess("light-voxels", text, queriesAt({{}}, {0.0})).replies.values[0];
    const double error = std::abs(passed - table->number(row, "transmittance"));
    (isBeam ? beams : skies) = std::max(isBeam ? beams : skies, error);
  }
  result.rows = {{"light-voxels, beams", beams, 1e-6, ""}, {"light-voxels, skies", skies, 2e-3, ""}};
  return result;
}

// ---- view factors

/// What a black receiver gets of the light that a sheet gives off, as a part: the sheet lets all light through and
/// gives off as much on its other side as comes in, evenly.
double factorBetween(const Canopy& canopy, std::size_t sheets, double power) {
  turtle::QueryBatch queries = queriesAt(std::vector<Vec3>(canopy.count()), {0.0, 0.0});
  queries.geometry = canopy.geometry();
  const auto replies = runProcess("light",
                                  R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"bounces":1,)"
                                  R"("directions":65536,"materials":[[0,0,1],[1,0,0],[2,1,0]]})",
                                  queries)
                           .replies.values;
  double sum = 0.0;
  for (std::size_t k = 2 * sheets + 1; k < replies.size(); k += 2) {
    sum += replies[k];
  }
  return sum / power;
}

CaseResult viewFactors(const Data& data) {
  CaseResult result;
  const auto table = ReferenceTable::read(data, "view_factors.tsv", result.missing);
  if (!table) {
    return result;
  }
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const std::string& kind = table->text(row, "kind");
    const double p1 = table->number(row, "p1");
    const double p2 = table->number(row, "p2");
    const double p3 = table->number(row, "p3");
    Canopy canopy;
    double power = 0.0;
    if (kind == "rectangles") {
      // the upper one is the sheet, lit from straight above; the lower one the receiver
      canopy.rectangle({0, p3, 0}, {0, 0, p2}, {p1, 0, 0}, 0);
      canopy.rectangle({0, 0, 0}, {0, 0, p2}, {p1, 0, 0}, 1);
      power = p1 * p2;
    } else if (kind == "corner") {
      // the lying one reflects the light from straight above, the other stands at its edge
      canopy.rectangle({0, 0, 0}, {0, 0, p3}, {p1, 0, 0}, 2);
      canopy.rectangle({0, 0, 0}, {0, 0, p3}, {0, p2, 0}, 1);
      power = p1 * p3;
    } else if (kind == "discs") {
      // polygons of so many sides that their area is that of the disc
      constexpr int kSides = 256;
      const auto disc = [&](double radius, double height, std::uint8_t colour) {
        const double wider = std::sqrt(2.0 * pi / kSides / core::sin(2.0 * pi / kSides));
        const auto corner = [&](int k) {
          const double angle = 2.0 * pi * k / kSides;
          return Vec3{radius * wider * core::cos(angle), height, radius * wider * core::sin(angle)};
        };
        for (int k = 0; k < kSides; ++k) {
          canopy.triangle({0, height, 0}, corner(k + 1), corner(k), colour);
        }
      };
      disc(p1, p3, 0);
      disc(p2, 0.0, 1);
      power = pi * p1 * p1;
    } else {
      continue;  // no surface of a plant gives off light as a whole sphere does
    }
    const double expected = table->number(row, "factor");
    const double factor = factorBetween(canopy, canopy.count() / 2, power);
    result.rows.push_back({kind + " " + table->text(row, "p1") + " " + table->text(row, "p2") + " " +
                               table->text(row, "p3") + ", relative",
                           std::abs(factor / expected - 1.0), 0.005, ""});
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
  double error = 0.0;
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const environment::SunPosition sun =
        environment::sunPosition(environment::julianDayOf(table->text(row, "universal_time")).value_or(0.0),
                                 table->number(row, "latitude"), table->number(row, "longitude"));
    error = std::max({error, std::abs(sun.elevationRadians * 180.0 / pi - table->number(row, "elevation")),
                      std::abs(sun.azimuthRadians * 180.0 / pi - table->number(row, "azimuth"))});
  }
  result.rows.push_back({"azimuth and elevation, degrees", error, 0.02, ""});
  return result;
}

}  // namespace

std::span<const Case> lightCases() {
  static constexpr std::array<Case, 7> kCases{
      {{"layers", "Black leaves in layers: Beer's law, Campbell 1986", true, blackLayers},
       {"layers-horizontal", "Horizontal leaves that scatter, over a ground: closed form", true, horizontalLayers},
       {"layers-spherical", "Spherical leaves that scatter, over a ground: discrete ordinates", false, sphericalLayers},
       {"rami-quick", "RAMI4PILPS, 80 crowns, sun at 60 degrees (Widlowski et al. 2011)", true, openForestsQuick},
       {"rami", "RAMI4PILPS, all open forests (Widlowski et al. 2011)", false, openForestsWhole},
       {"view-factors", "View factors of squares, rectangles and discs: closed forms", true, viewFactors},
       {"sun", "Positions of the sun after Reda & Andreas 2004", true, sunPositions}}};
  return kCases;
}

}  // namespace espalier::validation
