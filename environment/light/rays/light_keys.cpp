#include "environment/light/rays/light_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "environment/light/rays/light_bands.h"
#include "environment/light/sky.h"

namespace espalier::environment {

namespace {

constexpr std::array<std::string_view, 3> kSuns{"none", "direction", "position"};
constexpr std::array<std::string_view, 3> kUnits{"W", "umol", "mol"};
constexpr std::array<std::string_view, 2> kLightSensors{"horizontal", "fluxes"};
constexpr std::array kHigh{0.0, 1.0, 0.0};
constexpr std::array kOne{1.0};
constexpr std::array kPhotons{4.57};
constexpr std::array kReflectance{0.08};
constexpr std::array kTransmittance{0.05};
constexpr std::array kStemReflectance{0.2};
constexpr std::array kGroundReflectance{0.1};
constexpr std::array kLightKeys{
    ConfigurationKey{.name = "sky",
                     .kind = KeyKind::Choice,
                     .description = "brightness of the sky; overcast is (1 + 2 cos θ)/3, clear the CIE's with the sun",
                     .defaultText = "overcast",
                     .choices = kSkyNames},
    ConfigurationKey{.name = "diffuseIrradiance",
                     .description = "irradiance of a horizontal plane by the open sky; not used when sun is position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 200.0},
    ConfigurationKey{
        .name = "sun",
        .kind = KeyKind::Choice,
        .description = "none; direction: sunDirection; position: by the world's latitude, longitude and start",
        .defaultText = "none",
        .choices = kSuns},
    ConfigurationKey{.name = "start",
                     .kind = KeyKind::Text,
                     .description = "date and universal time of step 0, with latitude and longitude, instead of the "
                                    "world's; empty: the world's"},
    ConfigurationKey{.name = "latitude",
                     .description = "latitude, north positive, for the sun by position; needs start",
                     .unit = "degree",
                     .minimum = -90.0,
                     .maximum = 90.0},
    ConfigurationKey{.name = "longitude",
                     .description = "longitude, east positive, for the sun by position; needs start",
                     .unit = "degree",
                     .minimum = -360.0,
                     .maximum = 360.0},
    ConfigurationKey{.name = "sunDirection",
                     .kind = KeyKind::Numbers,
                     .description = "direction x, y, z towards the sun",
                     .defaultNumbers = kHigh,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "sunAzimuths",
                     .kind = KeyKind::Integer,
                     .description = "sun by direction: the mean of so many azimuths, evenly around the vertical",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "directIrradiance",
                     .description = "irradiance of a plane that faces the sun; not used when sun is position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 800.0},
    ConfigurationKey{.name = "atmosphere",
                     .description = "τ, the part of the light from the zenith that clear air lets through",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.7},
    ConfigurationKey{.name = "sunSamples",
                     .kind = KeyKind::Integer,
                     .description = "number of positions of the sun in a step; 1: the middle of the step",
                     .minimum = 1.0,
                     .maximum = 1000.0,
                     .defaultNumber = 24.0},
    ConfigurationKey{.name = "bands",
                     .kind = KeyKind::Numbers,
                     .description = "part of the irradiance in each band of the spectrum",
                     .minimum = 0.0,
                     .defaultNumbers = kOne,
                     .minimumCount = 1,
                     .maximumCount = 16},
    ConfigurationKey{.name = "unit",
                     .kind = KeyKind::Choice,
                     .description = "unit of the replies: W, µmol/s or mol/day",
                     .defaultText = "W",
                     .choices = kUnits},
    ConfigurationKey{.name = "photonsPerJoule",
                     .kind = KeyKind::Numbers,
                     .description = "photons per energy, µmol/J, in each band, or one number for all; 4.57 is PAR",
                     .unit = "umol/J",
                     .minimum = 0.0,
                     .defaultNumbers = kPhotons,
                     .minimumCount = 1},
    ConfigurationKey{.name = "reflectance",
                     .kind = KeyKind::Numbers,
                     .description = "part of the light that organs reflect, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kReflectance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "transmittance",
                     .kind = KeyKind::Numbers,
                     .description = "part of the light that passes organs, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kTransmittance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "stemReflectance",
                     .kind = KeyKind::Numbers,
                     .description = "part of the light that segments reflect, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kStemReflectance,
                     .minimumCount = 1},
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
    ConfigurationKey{.name = "bandLimits",
                     .kind = KeyKind::Rows,
                     .description = "wavelengths at which each band begins and ends; bands then follow from spectra",
                     .unit = "nm",
                     .minimum = 1.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "lightSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of the light: wavelength in nm, energy per nm in any unit",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "leafSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of leaves: wavelength in nm, reflectance, transmittance",
                     .minimum = 0.0,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "groundSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of the ground: wavelength in nm, reflectance",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
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
    ConfigurationKey{.name = "groundReflectance",
                     .kind = KeyKind::Numbers,
                     .description = "part of the light that the ground reflects, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kGroundReflectance,
                     .minimumCount = 1},
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

}  // namespace

extern constinit const ProcessEntry kLightProcess{
    .name = "light",
    .summary = kLightSummary,
    .source = "Meeus 1998, Astronomical Algorithms; Moon & Spencer 1942; Kittler 1967; Liu & Jordan 1960",
    .keys = kLightKeys,
    .make = makeLight};

double numberOfBand(const std::vector<double>& numbers, std::size_t band) {
  return numbers[std::min(band, numbers.size() - 1)];
}

std::vector<core::Diagnostic> checkLight(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors;
  const auto add = [&](const std::string& sentence, const std::string& hint) {
    errors.push_back(wrongConfiguration("light", sentence, hint));
  };
  errors = checkSpectra(configuration);
  const std::size_t limits = configuration.rows("bandLimits").size();
  const std::size_t bands = limits > 0 ? limits : configuration.numbers("bands").size();
  for (const std::string key :
       {"photonsPerJoule", "reflectance", "transmittance", "stemReflectance", "groundReflectance"}) {
    const std::size_t count = configuration.numbers(key).size();
    if (count != 1 && count != bands) {
      add("'" + key + "' has " + std::to_string(count) + " numbers for " + std::to_string(bands) + " bands",
          "give one number for each band, or one for all");
    }
  }
  for (std::size_t band = 0; band < bands && limits == 0 && errors.empty(); ++band) {
    if (numberOfBand(configuration.numbers("reflectance"), band) +
            numberOfBand(configuration.numbers("transmittance"), band) >
        1.0) {
      add("'reflectance' and 'transmittance' add up to more than 1 in band " + std::to_string(band + 1),
          "organs cannot scatter more light than they get");
    }
  }
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
  if (configuration.text("sky") == "clear" && configuration.text("sun") == "none") {
    add("a clear 'sky' is brightest around the sun, and 'sun' is none", "set sun to direction or position");
  }
  if (configuration.text("sensor") == "fluxes" &&
      !(configuration.flag("ground") && configuration.number("remainder") > 0.0)) {
    add("a sensor of fluxes needs a 'ground' and a 'remainder'", "write for example \"remainder\": 1e-4");
  }
  return errors;
}

}  // namespace espalier::environment
