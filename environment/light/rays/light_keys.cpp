#include "environment/light/rays/light_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "environment/light/daylight_keys.h"
#include "environment/light/light_bands.h"

namespace espalier::environment {

namespace {

constexpr std::array<std::string_view, 3> kUnits{"W", "umol", "mol"};
constexpr std::array<std::string_view, 2> kLightSensors{"horizontal", "fluxes"};
constexpr std::array kStemReflectance{0.2};
constexpr std::array kOwnLightKeys{
    ConfigurationKey{.name = "diffuseIrradiance",
                     .description = "irradiance of a horizontal plane by the open sky; not used when sun is position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 200.0},
    ConfigurationKey{.name = "unit",
                     .kind = KeyKind::Choice,
                     .description = "unit of the replies: W, µmol/s or mol/day",
                     .defaultText = "W",
                     .choices = kUnits},
    bandNumbersKey("stemReflectance", "part of the light that segments reflect, in each band, or one number for all",
                   kStemReflectance),
    ConfigurationKey{.name = "materials",
                     .kind = KeyKind::Rows,
                     .description = "organs of a colour: its number, then reflectance and transmittance of each band",
                     .minimum = 0.0,
                     .maximum = 255.0,
                     .minimumCount = 3},
    ConfigurationKey{.name = "bounces",
                     .kind = KeyKind::Integer,
                     .description = "number of times that light is scattered between organs",
                     .minimum = 0.0,
                     .maximum = 100.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "remainder",
                     .description = "part of the light that may be left when scattering ends, instead of a number of "
                                    "bounces; no light is lost or made; 0: bounces decides",
                     .minimum = 0.0,
                     .maximum = 0.1},
    ConfigurationKey{.name = "error",
                     .description = "error of the light of organs, relative to its mean: rays are doubled until it is "
                                    "reached; 0: directions and sunRays decide",
                     .minimum = 0.0,
                     .maximum = 1.0},
    ConfigurationKey{.name = "sunRays",
                     .kind = KeyKind::Integer,
                     .description = "number of rays from each triangle to each position of the sun; not given, with a "
                                    "remainder: as many as make half a million in all",
                     .minimum = 1.0,
                     .maximum = 4096.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "sensor",
                     .kind = KeyKind::Choice,
                     .description = "the answer to a query without an organ: the irradiance of a horizontal plane, or "
                                    "the fluxes of the stand",
                     .defaultText = "horizontal",
                     .choices = kLightSensors},
    ConfigurationKey{.name = "directions",
                     .kind = KeyKind::Integer,
                     .description = "least number of rays of an organ, over the whole sphere; each of its "
                                    "triangles has 16 or more",
                     .minimum = 8.0,
                     .maximum = 4194304.0,
                     .defaultNumber = 128.0},
    ConfigurationKey{.name = "plot",
                     .kind = KeyKind::Numbers,
                     .description =
                         "the stand repeats itself without end: smallest and largest of the first, then of the "
                         "second horizontal coordinate (x and z when y is up); none: plants stand alone",
                     .unit = "length",
                     .maximumCount = 4},
    ConfigurationKey{
        .name = "ground", .kind = KeyKind::Boolean, .description = "a ground under the plot that reflects"},
    ConfigurationKey{.name = "groundCells",
                     .kind = KeyKind::Integer,
                     .description = "squares of the ground along each side of the plot; in each the light is even",
                     .minimum = 1.0,
                     .maximum = 512.0,
                     .defaultNumber = 16.0},
    ConfigurationKey{
        .name = "groundHeight", .description = "height of the ground along the world's up", .unit = "length"},
    ConfigurationKey{.name = "segmentSides",
                     .kind = KeyKind::Integer,
                     .description = "number of sides of the prism that stands for a segment",
                     .minimum = 3.0,
                     .maximum = 64.0,
                     .defaultNumber = 5.0},
    ConfigurationKey{.name = "threads",
                     .kind = KeyKind::Integer,
                     .description = "number of threads that trace rays; it does not change the light",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 1.0},
};
constexpr auto kLightKeys = joinTables(kDaylightKeys, kBandKeys, kOwnLightKeys);

}  // namespace

extern constinit const ProcessEntry kLightProcess{
    .name = "light",
    .summary = kLightSummary,
    .source = "Meeus 1998, Astronomical Algorithms; Moon & Spencer 1942; Kittler 1967; Liu & Jordan 1960",
    .keys = kLightKeys,
    .make = makeLight};

std::vector<core::Diagnostic> checkLight(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors = checkBands("light", configuration, "stemReflectance");
  const auto add = [&](const std::string& sentence, const std::string& hint) {
    errors.push_back(wrongConfiguration("light", sentence, hint));
  };
  const std::size_t limits = configuration.rows("bandLimits").size();
  const std::size_t bands = limits > 0 ? limits : configuration.numbers("bands").size();
  for (const auto& row : configuration.rows("materials")) {
    bool isWrong = row.size() != 1 + 2 * bands || row[0] != std::floor(row[0]);
    for (std::size_t band = 0; !isWrong && band < bands; ++band) {
      isWrong = row[1 + 2 * band] + row[2 + 2 * band] > 1.0;
    }
    if (isWrong) {
      add("a row of 'materials' is not a colour number with reflectance and transmittance for each of " +
              std::to_string(bands) + " bands, together at most 1",
          "write for example \"materials\": [[3, 0.1, 0.05]]");
    }
  }
  const auto& plot = configuration.numbers("plot");
  if (!plot.empty() && (plot.size() != 4 || !(plot[0] < plot[1] && plot[2] < plot[3]))) {
    add("'plot' is not a smallest and a largest number for each of the two horizontal coordinates",
        "write for example \"plot\": [-5, 5, -5, 5]");
  }
  if (configuration.flag("ground") && plot.empty()) {
    add("a 'ground' needs a 'plot'", "write for example \"plot\": [-5, 5, -5, 5]");
  }
  std::ranges::move(checkDaylight("light", configuration), std::back_inserter(errors));
  if (configuration.text("sensor") == "fluxes" &&
      !(configuration.flag("ground") && configuration.number("remainder") > 0.0)) {
    add("a sensor of fluxes needs a 'ground' and a 'remainder'", "write for example \"remainder\": 1e-4");
  }
  return errors;
}

}  // namespace espalier::environment
