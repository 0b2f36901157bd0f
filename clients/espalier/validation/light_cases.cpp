// Benchmarks of light: layers of leaves, view factors, the sun. Lengths in m, light as parts of what comes in.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/validation/canopy_fluxes.h"
#include "clients/espalier/validation/closed_forms.h"
#include "clients/espalier/validation/discrete_ordinates.h"
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

/// A layer of so much leaf area in 40 voxels on each other.
Voxels voxelLayer(double leafAreaIndex, bool isHorizontal) {
  return {{1, 40, 1}, 1.0, std::vector<double>(40, leafAreaIndex / 40.0), isHorizontal ? "horizontal" : "spherical"};
}

/// Rows in voxels and with leaves at random.
CaseResult layers(const std::vector<LayerRow>& rows, bool isHorizontal) {
  CaseResult result;
  Largest voxels;
  Largest rays;
  result.across = "row";
  result.up = "absorbed part of the light";
  result.curves = {{"light-voxels", false, {}}, {"light", false, {}}, {"exact", true, {}}};
  const auto add = [&](Largest& largest, std::size_t curve, const Fluxes& fluxes, std::size_t row) {
    const LayerFluxes& exact = rows[row].exact;
    largest.add(fluxes, exact.absorbed, exact.reflected, exact.down);
    result.curves[curve].points.emplace_back(static_cast<double>(row + 1), fluxes.byPlants);
  };
  std::map<std::pair<double, std::string>, std::vector<std::size_t>> groups;  // rows by leaf area index and light
  for (std::size_t row = 0; row < rows.size(); ++row) {
    groups[{rows[row].leafAreaIndex, rows[row].zenith}].push_back(row);
    result.curves[2].points.emplace_back(static_cast<double>(row + 1), rows[row].exact.absorbed);
  }
  for (const auto& [key, group] : groups) {
    constexpr double kSide = 10.0;
    Canopy canopy;
    canopy.layer(kSide, 10.0, key.first, 40'000, isHorizontal);
    for (std::size_t begin = 0; begin < group.size(); begin += kMostBands) {
      std::vector<Band> bands;
      for (std::size_t i = begin; i < std::min(begin + kMostBands, group.size()); ++i) {
        bands.push_back(rows[group[i]].band);
      }
      const Light light = lightOf(key.second);
      const std::vector<Fluxes> byVoxels = voxelFluxes(voxelLayer(key.first, isHorizontal), bands, light);
      const std::vector<Fluxes> byRays = rayFluxes(canopy, kSide, bands, light, 32, 16);
      for (std::size_t i = 0; i < bands.size(); ++i) {
        add(voxels, 0, byVoxels[i], group[begin + i]);
        add(rays, 1, byRays[i], group[begin + i]);
      }
    }
  }
  for (Curve& curve : result.curves) {
    std::sort(curve.points.begin(), curve.points.end());
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

CaseResult sphericalLayers(const Data&) {
  std::vector<LayerRow> rows;
  const auto add = [&](double index, const std::string& zenith, double rho, double tau, double ground) {
    const Light light = lightOf(zenith);
    const auto angle = light.zenith < 0.0 ? std::nullopt : std::optional(light.zenith);
    rows.push_back({index, zenith, {rho, tau, ground}, sphericalLayer(index, rho, tau, ground, angle)});
  };
  for (const double index : {1.0, 2.5, 5.0}) {
    for (const std::string zenith : {"27.4643", "60", "uniform"}) {
      // leaves and grounds of RAMI4PILPS in PAR and in the near infrared
      for (const double ground : {0.0, 0.1217, 0.964}) {
        add(index, zenith, 0.0735, 0.0566, ground);
      }
      for (const double ground : {0.0, 0.2142, 0.5568}) {
        add(index, zenith, 0.3912, 0.4146, ground);
      }
    }
  }
  for (const std::string zenith : {"30", "uniform"}) {
    add(2.0, zenith, 0.5, 0.5, 1.0);
  }
  return layers(rows, false);
}

// ---- layers of black leaves

/// A row of the table of black leaves.
struct BlackLayer {
  std::string leaves;
  double ratio = 1.0;  // of the ellipsoid
  std::string light;   // "zenith30", "uniform", "overcast"
  double index = 1.0;

  [[nodiscard]] double exact() const { return passedBlackLeaves(leaves, ratio, light, index); }
  [[nodiscard]] bool isBeam() const { return light.starts_with("zenith"); }
  [[nodiscard]] Light lightOfRow() const { return lightOf(isBeam() ? light.substr(6) : light); }
};

std::vector<BlackLayer> blackLayerRows() {
  std::vector<BlackLayer> rows;
  for (const double index : {1.0, 3.0}) {
    for (const std::string leaves : {"horizontal", "vertical", "spherical", "planophile", "erectophile", "plagiophile",
                                     "extremophile", "uniform"}) {
      for (const std::string light : {"zenith0", "zenith30", "zenith60", "zenith75"}) {
        rows.push_back({leaves, 1.0, light, index});
      }
    }
    for (const double ratio : {0.5, 2.0}) {
      for (const std::string light : {"zenith0", "zenith30", "zenith60", "zenith75", "uniform", "overcast"}) {
        rows.push_back({"ellipsoidal", ratio, light, index});
      }
    }
    for (const std::string leaves : {"horizontal", "vertical", "spherical"}) {
      rows.push_back({leaves, 1.0, "uniform", index});
      rows.push_back({leaves, 1.0, "overcast", index});
    }
  }
  return rows;
}

double passedInVoxels(const BlackLayer& row) {
  std::string text = R"({"voxelSize":1,"position":[0,0,0],"periodic":true,"gridSize":[1,10,1],"leafAngles":")" +
                     row.leaves + R"(","ellipsoidRatio":)" + numberText(row.ratio) + R"(,"leafAreaDensity":)" +
                     listOf(std::vector<double>(10, row.index / 10.0));
  if (row.isBeam()) {
    const Vec3 sun = row.lightOfRow().direction();
    text += R"(,"directions":[)" + listOf({sun.x, sun.y, sun.z, 1.0}) + "]}";
  } else {
    text += R"(,"zenithAngles":32,"azimuthAngles":2,"sky":")" + row.light + R"("})";
  }
  return runProcess("light-voxels", text, queriesAt({{}}, {0.0})).replies.values[0];
}

/// Leaves at random in a layer whose normals have the distribution of a row.
double passedLeaves(const BlackLayer& row, std::size_t leaves, int threads) {
  constexpr double kSide = 10.0;
  Canopy canopy;
  const LeafAngleTable angles(row.leaves, row.ratio);
  for (std::size_t i = 0; i < leaves; ++i) {
    const Vec3 place{kSide * canopy.random(), 0.5 + 10.0 * canopy.random(), kSide * canopy.random()};
    const double angle = angles.at(canopy.random());
    const double azimuth = 2.0 * pi * canopy.random();
    canopy.leaf(place, {core::sin(angle) * core::cos(azimuth), core::cos(angle), core::sin(angle) * core::sin(azimuth)},
                row.index * kSide * kSide / static_cast<double>(leaves));
  }
  return rayFluxes(canopy, kSide, {Band{}}, row.lightOfRow(), 16, 16, threads).front().down;
}

/// The light that passes below 60° of the zenith by the kind of leaves, and the closed form.
void addBlackCurves(CaseResult& result) {
  result.across = "zenith angle, degrees";
  result.up = "part of the light that passes black leaves of index 1";
  for (const std::string leaves : {"horizontal", "vertical", "spherical", "planophile", "erectophile", "plagiophile",
                                   "extremophile", "uniform", "ellipsoidal"}) {
    Curve own{leaves, false, {}};
    Curve exact{leaves + ", exact", true, {}};
    for (int zenith = 0; zenith <= 80; zenith += 10) {
      const BlackLayer row{leaves, leaves == "ellipsoidal" ? 2.0 : 1.0, "zenith" + std::to_string(zenith), 1.0};
      own.points.emplace_back(zenith, passedInVoxels(row));
      exact.points.emplace_back(zenith, row.exact());
    }
    result.curves.push_back(std::move(own));
    result.curves.push_back(std::move(exact));
  }
}

CaseResult blackLayers(const Data&) {
  CaseResult result;
  LargestError beams;
  LargestError skies;
  LargestError leaves;
  for (const BlackLayer& row : blackLayerRows()) {
    (row.isBeam() ? beams : skies).add(std::abs(passedInVoxels(row) - row.exact()));
    // some with leaves; all of them are the case layers-light
    if (row.leaves == "spherical" && row.index == 1.0 && (row.light == "zenith60" || row.light == "uniform")) {
      leaves.add(std::abs(passedLeaves(row, 40'000, 1) - row.exact()));
    }
  }
  result.rows = {{"light-voxels, beams", beams.value(), 1e-6, ""},
                 {"light-voxels, skies", skies.value(), 2e-3, ""},
                 {"light, 40000 leaves, a beam and a sky", leaves.value(), 0.01, ""}};
  addBlackCurves(result);
  return result;
}

CaseResult blackLayersOfLeaves(const Data&) {
  CaseResult result;
  LargestError beams;
  LargestError skies;
  result.across = "row of the table";
  result.up = "part of the light that passes black leaves";
  result.curves = {{"light", false, {}}, {"exact", true, {}}};
  double number = 0.0;
  for (const BlackLayer& row : blackLayerRows()) {
    const double passed = passedLeaves(row, 40'000, 2);
    (row.isBeam() ? beams : skies).add(std::abs(passed - row.exact()));
    number += 1.0;
    result.curves[0].points.emplace_back(number, passed);
    result.curves[1].points.emplace_back(number, row.exact());
  }
  result.rows = {{"light, 40000 leaves, beams", beams.value(), 0.01, ""},
                 {"light, 40000 leaves, skies", skies.value(), 0.01, ""}};
  return result;
}

// ---- what comes in goes out

/// Leaves that take nothing over a ground that takes nothing, and a leaf over the whole plot.
CaseResult closure(const Data&) {
  CaseResult result;
  LargestError rays;
  LargestError voxels;
  const Band white{0.5, 0.5, 1.0};
  for (const double index : {0.5, 2.0, 5.0}) {
    for (const bool isHorizontal : {false, true}) {
      Canopy canopy;
      canopy.layer(10.0, 10.0, index, 1000, isHorizontal);
      for (const std::string light : {"27.4643", "60", "83.5289", "uniform", "overcast"}) {
        rays.add(std::abs(1.0 - rayFluxes(canopy, 10.0, {white}, lightOf(light), 32, 16).front().up));
        voxels.add(std::abs(1.0 - voxelFluxes(voxelLayer(index, isHorizontal), {white}, lightOf(light)).front().up));
      }
    }
  }
  result.rows = {{"light, without losses, reflected", rays.value(), 1e-3, ""},
                 {"light-voxels, without losses, reflected", voxels.value(), 1e-3, ""}};
  LargestError up;
  LargestError down;
  for (const Band& band : {Band{0.3, 0.2, 0.4}, Band{0.0735, 0.0566, 0.964}, Band{0.3912, 0.4146, 0.5568}}) {
    Canopy sheet;
    sheet.rectangle({0, 2, 0}, {0, 0, 10}, {10, 0, 0});
    for (const std::string light : {"27.4643", "60", "uniform"}) {
      const Fluxes fluxes = rayFluxes(sheet, 10.0, {band}, lightOf(light), 256, 16).front();
      const double back = 1.0 - band.rho * band.ground;
      up.add(std::abs(fluxes.up - band.rho - band.tau * band.tau * band.ground / back));
      down.add(std::abs(fluxes.down - band.tau / back));
    }
  }
  result.rows.push_back({"light, a leaf over the plot, reflected", up.value(), 1e-3, ""});
  result.rows.push_back({"light, a leaf over the plot, down at the ground", down.value(), 1e-3, ""});
  return result;
}

// ---- view factors

/// A sheet that gives off light, receivers of it, and between them in the order of the organs what is neither.
struct Arrangement {
  Canopy canopy;
  std::size_t firstReceiver = 0;
  double area = 0.0;          // of the sheet
  double receiverArea = 0.0;  // both sides that look at the sheet
};

/// A polygon of so many triangles that its area is that of the disc.
void addDisc(Canopy& canopy, double radius, double height, std::uint8_t colour) {
  constexpr int kSides = 256;
  const double wider = std::sqrt(2.0 * pi / kSides / core::sin(2.0 * pi / kSides));
  const auto corner = [&](int k) {
    const double angle = 2.0 * pi * k / kSides;
    return Vec3{radius * wider * core::cos(angle), height, radius * wider * core::sin(angle)};
  };
  for (int k = 0; k < kSides; ++k) {
    canopy.triangle({0, height, 0}, corner(k + 1), corner(k), colour);
  }
}

/// A sphere of triangles that together have its surface: from far away they are as large as it is.
void addSphere(Canopy& canopy, const Vec3& centre, double radius, std::uint8_t colour) {
  constexpr int kAcross = 32;
  constexpr int kUp = 16;
  const auto corner = [](int i, int k) {
    const double zenith = pi * k / kUp;
    const double angle = 2.0 * pi * i / kAcross;
    return Vec3{core::sin(zenith) * core::cos(angle), core::cos(zenith), core::sin(zenith) * core::sin(angle)};
  };
  const auto forEach = [&](const auto& take) {
    for (int k = 0; k < kUp; ++k) {
      for (int i = 0; i < kAcross; ++i) {
        if (k > 0) {
          take(corner(i, k), corner(i + 1, k), corner(i + 1, k + 1));
        }
        if (k + 1 < kUp || k == 0) {
          take(corner(i, k), corner(i + 1, k + 1), corner(i, k + 1));
        }
      }
    }
  };
  double area = 0.0;
  forEach([&](const Vec3& a, const Vec3& b, const Vec3& c) { area += 0.5 * core::length(core::cross(b - a, c - a)); });
  const double scale = radius * std::sqrt(4.0 * pi / area);
  forEach([&](const Vec3& a, const Vec3& b, const Vec3& c) {
    canopy.triangle(centre + a * scale, centre + b * scale, centre + c * scale, colour);
  });
}

// by colour: lets all light through, takes all, gives all back
constexpr std::uint8_t kLetsThrough = 0;
constexpr std::uint8_t kBlack = 1;
constexpr std::uint8_t kWhite = 2;

/// Two surfaces, the sheet first; the light comes from straight above.
Arrangement arrangementOf(const std::string& kind, double p1, double p2, double p3) {
  Arrangement both;
  if (kind == "rectangles") {
    both.canopy.rectangle({0, p3, 0}, {0, 0, p2}, {p1, 0, 0}, kLetsThrough);
    both.firstReceiver = both.canopy.count();
    both.canopy.rectangle({0, 0, 0}, {0, 0, p2}, {p1, 0, 0}, kBlack);
    both.area = both.receiverArea = p1 * p2;
  } else if (kind == "corner") {
    // the lying one reflects the light, the other stands at its edge
    both.canopy.rectangle({0, 0, 0}, {0, 0, p3}, {p1, 0, 0}, kWhite);
    both.firstReceiver = both.canopy.count();
    both.canopy.rectangle({0, 0, 0}, {0, 0, p3}, {0, p2, 0}, kBlack);
    both.area = p1 * p3;
    both.receiverArea = p2 * p3;
  } else if (kind == "sphere") {
    // a black roof around the sheet shades the sphere below a corner of it
    const double wide = 2.0 * p3;
    both.canopy.rectangle({0, p3, 0}, {0, 0, p2}, {p1, 0, 0}, kLetsThrough);
    both.canopy.rectangle({-wide, p3, -wide}, {0, 0, 2.0 * wide}, {wide, 0, 0}, kBlack);
    both.canopy.rectangle({0, p3, -wide}, {0, 0, wide}, {wide, 0, 0}, kBlack);
    both.firstReceiver = both.canopy.count();
    const double radius = 0.5 * p3;
    addSphere(both.canopy, {0, 0, 0}, radius, kBlack);
    both.area = p1 * p2;
    both.receiverArea = 4.0 * pi * radius * radius;
  } else {
    addDisc(both.canopy, p1, p3, kLetsThrough);
    both.firstReceiver = both.canopy.count();
    addDisc(both.canopy, p2, 0.0, kBlack);
    both.area = pi * p1 * p1;
    both.receiverArea = pi * p2 * p2;
  }
  return both;
}

/// The part of the light of a sheet that black receivers get: the sheet lets all light through, or gives it back,
/// evenly. The receivers have so many rays in all.
double factorBetween(const Arrangement& both, std::size_t rays) {
  turtle::QueryBatch queries = queriesAt(std::vector<Vec3>(both.canopy.count()), {0.0, 0.0});
  queries.geometry = both.canopy.geometry();
  const std::size_t receivers = both.canopy.count() - both.firstReceiver;
  const auto replies = runProcess("light",
                                  R"({"diffuseIrradiance":0,"sun":"direction","directIrradiance":1,"bounces":1,)"
                                  R"("materials":[[0,0,1],[1,0,0],[2,1,0]],"directions":)" +
                                      std::to_string(rays / receivers) + "}",
                                  queries)
                           .replies.values;
  double sum = 0.0;
  for (std::size_t k = 2 * both.firstReceiver + 1; k < replies.size(); k += 2) {
    sum += replies[k];
  }
  return sum / both.area;
}

struct ViewFactorRow {
  const char* kind;
  double p1, p2, p3;

  [[nodiscard]] std::string name() const {
    return std::string(kind) + " " + numberText(p1) + " " + numberText(p2) + " " + numberText(p3);
  }
  [[nodiscard]] double exact() const { return viewFactor(kind, p1, p2, p3); }
  /// By the process `light` with so many rays.
  [[nodiscard]] double found(std::size_t rays) const {
    const std::string name = kind;
    // F₁₂ A₁ = F₂₁ A₂: a larger disc would have light past the sheet, and the sphere is the receiver
    if (name == "discs" && p2 > p1) {
      return factorBetween(arrangementOf(name, p2, p1, p3), rays) * p2 * p2 / (p1 * p1);
    }
    const Arrangement both = arrangementOf(name, p1, p2, p3);
    const double factor = factorBetween(both, rays);
    return name == "sphere" ? factor * both.area / both.receiverArea : factor;
  }
};

CaseResult viewFactors(const Data&) {
  constexpr std::size_t kMany = 2'097'152;
  constexpr std::size_t kAsHelios = 100'000;
  CaseResult result;
  result.across = "arrangement";
  result.up = "view factor";
  result.curves = {{"light", false, {}}, {"exact", true, {}}};
  std::map<std::string, LargestError> withFew;
  for (const ViewFactorRow& row :
       {ViewFactorRow{"discs", 1, 1, 1}, ViewFactorRow{"discs", 1, 0.5, 0.75}, ViewFactorRow{"discs", 0.5, 2, 1},
        ViewFactorRow{"rectangles", 1, 1, 1}, ViewFactorRow{"rectangles", 1, 2, 0.5},
        ViewFactorRow{"rectangles", 1, 1, 3}, ViewFactorRow{"corner", 1, 1, 1}, ViewFactorRow{"corner", 1, 2, 1},
        ViewFactorRow{"corner", 2, 1, 3}, ViewFactorRow{"sphere", 1.5, 2, 0.75}, ViewFactorRow{"sphere", 1, 1, 1}}) {
    const double factor = row.found(kMany);
    const auto number = static_cast<double>(result.rows.size() + 1);
    result.curves[0].points.emplace_back(number, factor);
    result.curves[1].points.emplace_back(number, row.exact());
    result.rows.push_back({row.name() + ", relative", std::abs(factor / row.exact() - 1.0), 0.005, ""});
    withFew[row.kind].add(std::abs(row.found(kAsHelios) / row.exact() - 1.0));
  }
  for (const auto& [kind, error] : withFew) {
    result.rows.push_back({kind + ", all, with 100,000 rays, relative", error.value(), std::nullopt, ""});
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
  result.across = "row of the table";
  result.up = "elevation of the sun, degrees";
  result.curves = {{"Espalier", false, {}}, {"Reda & Andreas", true, {}}};
  for (std::size_t row = 0; row < table->rowCount(); ++row) {
    const std::string& time = table->text(row, "universal_time");
    const auto day = environment::julianDayOf(time);
    if (!day) {
      table->refuse(row, "expected a date in the column 'universal_time', found '" + time +
                             "'. Write one such as 2003-10-17T19:30:30");
    }
    const environment::SunPosition sun =
        environment::sunPosition(*day, table->number(row, "latitude"), table->number(row, "longitude"));
    error.add(std::abs(sun.elevationRadians * 180.0 / pi - table->number(row, "elevation")));
    error.add(std::abs(sun.azimuthRadians * 180.0 / pi - table->number(row, "azimuth")));
    result.curves[0].points.emplace_back(static_cast<double>(row), sun.elevationRadians * 180.0 / pi);
    result.curves[1].points.emplace_back(static_cast<double>(row), table->number(row, "elevation"));
  }
  result.rows.push_back({"azimuth and elevation, degrees", error.value(), 0.02, ""});
  return result;
}

}  // namespace

std::span<const Case> lightCases() {
  static constexpr std::array<Case, 7> kCases{
      {{"layers", "Black leaves in layers: Beer's law, Campbell 1986", true, blackLayers},
       {"layers-light", "Black leaves in layers, all rows by leaves at random in light", false, blackLayersOfLeaves},
       {"closure", "Leaves without losses, and a leaf over the plot: closed forms", false, closure},
       {"layers-horizontal", "Horizontal leaves that scatter, over a ground: closed form", false, horizontalLayers},
       {"layers-spherical", "Spherical leaves that scatter, over a ground: discrete ordinates", false, sphericalLayers},
       {"view-factors", "View factors of squares, rectangles, discs and spheres: closed forms", true, viewFactors},
       {"sun", "Positions of the sun after Reda & Andreas 2004", true, sunPositions}}};
  return kCases;
}

}  // namespace espalier::validation
