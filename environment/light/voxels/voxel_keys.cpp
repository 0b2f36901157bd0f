#include "environment/light/voxels/voxel_keys.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>

#include "environment/geometry/grid_keys.h"
#include "environment/light/daylight_keys.h"
#include "environment/light/light_bands.h"
#include "environment/light/voxels/leaf_angles.h"

namespace espalier::environment {

namespace {

constexpr std::array<std::string_view, 2> kMethods{"turbid", "shadow"};
constexpr std::array<std::string_view, 4> kVoxelUnits{"W", "umol", "mol", "relative"};
constexpr std::array<std::string_view, 2> kVoxelSensors{"horizontal", "fluxes"};
constexpr std::array kVoxelGridSize{40.0, 40.0, 40.0};
constexpr std::array kVoxelPosition{-10.0, 0.0, -10.0};
constexpr std::array kBlack{1.0};
constexpr std::size_t kMostVoxels = std::size_t{1} << 27;
constexpr std::array kOwnVoxelKeys{
    ConfigurationKey{.name = "method",
                     .kind = KeyKind::Choice,
                     .description = "turbid: Beer-Lambert through the leaf area density; shadow: additive shadow "
                                    "propagation",
                     .defaultText = "turbid",
                     .choices = kMethods},
    gridSizeKey(kVoxelGridSize, "number of voxels along x, y, z"),
    ConfigurationKey{.name = "voxelSize",
                     .description = "side of a voxel, which is a cube",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.5},
    positionKey(kVoxelPosition),
    ConfigurationKey{.name = "periodic",
                     .kind = KeyKind::Boolean,
                     .description = "the box repeats itself without end in the horizontal directions: a stand"},
    ConfigurationKey{.name = "zenithAngles",
                     .kind = KeyKind::Integer,
                     .description = "turbid: rings of the sky's directions, at Gauss points of cos θ",
                     .minimum = 1.0,
                     .maximum = 64.0,
                     .defaultNumber = 6.0},
    ConfigurationKey{.name = "azimuthAngles",
                     .kind = KeyKind::Integer,
                     .description = "turbid: directions in each ring",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 8.0},
    ConfigurationKey{.name = "directions",
                     .kind = KeyKind::Rows,
                     .description =
                         "turbid: instead of a sky, directions x, y, z towards the light and the part of the "
                         "irradiance of a horizontal plane that comes from there",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{.name = "irradiance",
                     .description =
                         "turbid, without a sun: of a horizontal plane in the open; 1: all light is relative; "
                         "the weather's radiation takes its place",
                     .unit = "any",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "diffuseIrradiance",
                     .description = "turbid, sun by direction: irradiance of a horizontal plane by the sky",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 200.0},
    ConfigurationKey{.name = "unit",
                     .kind = KeyKind::Choice,
                     .description =
                         "turbid: unit of the light: W/m², or that of irradiance; µmol/(m² s); mol/(m² day); "
                         "relative: parts of the light of each band in the open",
                     .defaultText = "W",
                     .choices = kVoxelUnits},
    ConfigurationKey{
        .name = "leafAngles",
        .kind = KeyKind::Choice,
        .description = "turbid: distribution of the leaf normals (de Wit 1965; ellipsoidal: Campbell 1986)",
        .defaultText = "spherical",
        .choices = kLeafAngleNames},
    ConfigurationKey{.name = "ellipsoidRatio",
                     .description =
                         "turbid, ellipsoidal: horizontal over vertical axis χ; above 1 the leaves are rather "
                         "horizontal",
                     .minimum = 0.0,
                     .maximum = 1e6,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.0},
    bandNumbersKey(
        "absorptance",
        "turbid: part of the light that a leaf absorbs, in each band, or one number for all; not given, with "
        "spectra: what leaves do not scatter",
        kBlack),
    ConfigurationKey{.name = "scattering",
                     .kind = KeyKind::Boolean,
                     .description = "turbid: leaves scatter light with reflectance and transmittance, and the ground "
                                    "below the box reflects it"},
    ConfigurationKey{.name = "remainder",
                     .description = "scattering: part of the light that may be left when it ends",
                     .minimum = 0.0,
                     .maximum = 0.1,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1e-4},
    ConfigurationKey{.name = "sensor",
                     .kind = KeyKind::Choice,
                     .description = "scattering: the answer to a query with a leaf area of 0: light on a horizontal "
                                    "plane, or the fluxes of the stand",
                     .defaultText = "horizontal",
                     .choices = kVoxelSensors},
    ConfigurationKey{.name = "leafAreaDensity",
                     .kind = KeyKind::Numbers,
                     .description =
                         "turbid: leaf area per volume of every voxel, x fastest, then y, then z, of plants that are "
                         "not simulated; a \"fieldFile\" brings it; none: there are none",
                     .unit = "1/length",
                     .minimum = 0.0},
    ConfigurationKey{.name = "fieldUnit",
                     .kind = KeyKind::Text,
                     .description = "unit of 'leafAreaDensity', as 1/m; another one than that of the world is refused; "
                                    "a \"fieldFile\" brings it; none: that of the world"},
    ConfigurationKey{.name = "fullLight",
                     .description = "shadow: C, the light without shadow",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "shadowStrength",
                     .description = "shadow: a, the shadow in the own voxel",
                     .minimum = 0.0,
                     .defaultNumber = 0.2},
    ConfigurationKey{.name = "shadowBase",
                     .description = "shadow: b, by which the shadow is weaker with every voxel further down",
                     .minimum = 1.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "shadowDepth",
                     .kind = KeyKind::Integer,
                     .description = "shadow: how many voxels down it reaches",
                     .minimum = 0.0,
                     .maximum = 1000.0,
                     .defaultNumber = 8.0},
};
constexpr auto kLightVoxelsKeys = joinTables(kOwnVoxelKeys, kDaylightKeys, kBandKeys);

}  // namespace

extern constinit const ProcessEntry kLightVoxelsProcess{
    .name = "light-voxels",
    .summary = kLightVoxelsSummary,
    .source =
        "Monsi & Saeki 1953; Ross 1981; Goudriaan 1977; Campbell 1986; Carlson & Lathrop 1968; Palubicki et al. "
        "2009, Self-organizing tree models for image synthesis",
    .keys = kLightVoxelsKeys,
    .make = makeLightVoxels};

std::vector<core::Diagnostic> checkLightVoxels(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors = checkBands("light-voxels", configuration, "absorptance");
  std::ranges::move(checkDaylight("light-voxels", configuration), std::back_inserter(errors));
  const auto add = [&](const std::string& sentence, const std::string& hint) {
    errors.push_back(wrongConfiguration("light-voxels", sentence, hint));
  };
  const auto cells = cellsOf(configuration);
  if (auto problem = tooManyCells("light-voxels", cells, kMostVoxels)) {
    errors.push_back(std::move(*problem));
  }
  const std::size_t cellCount = cells[0] * cells[1] * cells[2];
  const std::size_t densities = configuration.numbers("leafAreaDensity").size();
  if (densities != 0 && densities != cellCount) {
    add("'leafAreaDensity' has " + std::to_string(densities) + " numbers for " + std::to_string(cellCount) + " voxels",
        "give one for every voxel, or none");
  }
  if (!configuration.rows("directions").empty() && configuration.text("sun") != "none") {
    add("'directions' and 'sun' both say where light comes from", "leave one of the two out");
  }
  if (configuration.flag("scattering")) {
    if (configuration.text("method") != "turbid") {
      add("'scattering' needs the method turbid", "leave one of the two out");
    }
    if (std::ranges::any_of(configuration.numbers("absorptance"), [](double part) { return part != 1.0; })) {
      add("'absorptance' and 'scattering' set the same thing",
          "remove 'absorptance': it is 1 - reflectance - transmittance");
    }
  } else if (configuration.text("sensor") == "fluxes") {
    add("a 'sensor' of fluxes needs 'scattering'", "write \"scattering\": true");
  }
  return errors;
}

}  // namespace espalier::environment
