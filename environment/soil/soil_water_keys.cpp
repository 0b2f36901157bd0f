#include "environment/soil/soil_water_keys.h"

#include <string>

#include "engine/core/elementary.h"
#include "environment/base/default_lengths.h"
#include "environment/base/number_text.h"
#include "environment/geometry/grid_keys.h"
#include "environment/obstacles/obstacle_scene.h"

namespace espalier::environment {

namespace {

constexpr std::array kSoilWaterGridSize{1.0, 20.0, 1.0};
constexpr std::array kCellSize{1.0, 0.05, 1.0};
constexpr std::array kSoilWaterPosition{-0.5, -1.0, -0.5};
constexpr std::array<std::string_view, 2> kStarts{"head", "waterTable"};
constexpr std::array<std::string_view, 2> kSoils{"vanGenuchten", "gardner"};
constexpr std::array<std::string_view, 2> kEntries{"flow", "concentration"};
constexpr std::array<std::string_view, 2> kSurfaces{"weather", "head"};
constexpr std::array<std::string_view, 2> kEvaporations{"rows", "weather"};
constexpr std::array<std::string_view, 3> kBottoms{"free", "closed", "head"};
constexpr std::size_t kSoilWaterMaximumCellCount = std::size_t{1} << 24;

// far beyond dry soil; with 1e12 the internal time steps of a column that drains have no end
constexpr double kMostHead = 1e9;
// a kilometre of water in millimetres; with 1e9 at a border no step converges
constexpr double kMostBorderHead = 1e6;
// the widest that soils have in metres or millimetres: α of clay, α of stones, conductivity of stones
constexpr double kLeastAlpha = 1e-6;
constexpr double kMostAlpha = 1e4;
constexpr double kMostConductivity = 1e9;
// of van Genuchten's n; published fits lie between. Nearer to 1 a time step has no end, beyond no step converges
constexpr double kLeastN = 1.005;
constexpr double kMostN = 15.0;
constexpr std::array kSoilWaterOwnKeys{
    gridSizeKey(kSoilWaterGridSize, "cells along x, y, z; one along both horizontal directions: a column"),
    sidesKey("cellSize", "sides of a cell along x, y, z; upwards the mean; the default is converted from metres",
             kCellSize),
    ConfigurationKey{.name = "growth",
                     .description = "height of a cell over that of the cell above it, in a box of the same height",
                     .unit = "1",
                     .minimum = 0.5,
                     .maximum = 2.0,
                     .defaultNumber = 1.0},
    positionKey(kSoilWaterPosition),
    ConfigurationKey{
        .name = "layers",
        .kind = KeyKind::Rows,
        .description = "layers from the top: thickness (length; the last one continues below), residual and saturated "
                       "water content, van Genuchten's α (1/length) and n, saturated conductivity "
                       "(length/day); none: loam after Carsel and Parrish (1988)",
        .minimum = 0.0,
        .minimumCount = 6,
        .maximumCount = 6},
    ConfigurationKey{.name = "soil",
                     .kind = KeyKind::Choice,
                     .description = "vanGenuchten: van Genuchten's and Mualem's functions; gardner: saturation and "
                                    "relative conductivity e^(αh), where the layers' n means nothing",
                     .defaultText = "vanGenuchten",
                     .choices = kSoils},
    ConfigurationKey{.name = "specificStorage",
                     .description = "water that saturated soil takes up with the head; the default is converted from "
                                    "metres",
                     .unit = "1/length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1e-6},
    ConfigurationKey{.name = "initially",
                     .kind = KeyKind::Choice,
                     .description =
                         "head: initialHead everywhere; waterTable: hydrostatic equilibrium with a water table "
                         "at waterTableDepth",
                     .defaultText = "head",
                     .choices = kStarts},
    ConfigurationKey{.name = "initialHead",
                     .description = "initial pressure head; the default is converted from metres",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = kMostHead,
                     .defaultNumber = -1.0},
    ConfigurationKey{.name = "initialHeads",
                     .kind = KeyKind::Numbers,
                     .description = "pressure head of every cell, x fastest, then y, then z, instead of 'initially'; a "
                                    "\"fieldFile\" brings them; none: as 'initially' says",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = kMostHead},
    ConfigurationKey{.name = "fieldUnit",
                     .kind = KeyKind::Text,
                     .description = "unit of 'initialHeads'; another one than the world's unit of length is refused; a "
                                    "\"fieldFile\" brings it; none: that of the world"},
    ConfigurationKey{.name = "waterTableDepth",
                     .description = "depth of the water table below the top of the ground; the default is converted "
                                    "from metres",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = kMostHead,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "surface",
                     .kind = KeyKind::Choice,
                     .description = "weather: rain and evaporation; head: topHead",
                     .defaultText = "weather",
                     .choices = kSurfaces},
    ConfigurationKey{.name = "topHead",
                     .description = "pressure head at the surface",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = kMostBorderHead},
    ConfigurationKey{.name = "rain",
                     .kind = KeyKind::Rows,
                     .description = "day, rain (length/day) from then on; rain that cannot get in runs off",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "evaporation",
                     .kind = KeyKind::Rows,
                     .description = "day, potential evaporation (length/day) from then on",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "evaporationBy",
                     .kind = KeyKind::Choice,
                     .description = "rows: 'evaporation'; weather: what a wet surface gives off (Penman 1948) by the "
                                    "weather's global radiation, temperature, humidity and wind, hour by hour",
                     .defaultText = "rows",
                     .choices = kEvaporations},
    ConfigurationKey{.name = "groundLight",
                     .kind = KeyKind::Rows,
                     .description = "day, part of the weather's global radiation that reaches the ground from then on; "
                                    "none: all",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "albedo",
                     .description = "part of the global radiation that the ground reflects",
                     .unit = "1",
                     .minimum = 0.0,
                     .maximum = 1.0},
    ConfigurationKey{.name = "longWaveLoss",
                     .description = "radiation that the ground loses in long waves, and heat that goes into it",
                     .unit = "W/m^2",
                     .minimum = -1e4,
                     .maximum = 1e4},
    ConfigurationKey{.name = "roughness",
                     .description = "aerodynamic roughness of the ground; evaporationBy weather needs it",
                     .unit = "m",
                     .minimum = 0.0},
    ConfigurationKey{.name = "windHeight",
                     .description = "height at which wind, temperature and humidity are measured",
                     .unit = "m",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "airPressure",
                     .description = "pressure of the air",
                     .unit = "kPa",
                     .minimum = 20.0,
                     .maximum = 120.0,
                     .defaultNumber = 101.3},
    ConfigurationKey{.name = "weatherPeriod",
                     .description = "days after which rain, evaporation and groundLight repeat; 0: never",
                     .unit = "day",
                     .minimum = 0.0},
    ConfigurationKey{.name = "driestHead",
                     .description = "pressure head of a surface that is dry: limits evaporation; the default is "
                                    "converted from metres",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = 0.0,
                     .defaultNumber = -150.0},
    ConfigurationKey{.name = "bottom",
                     .kind = KeyKind::Choice,
                     .description = "free: drainage by gravity; closed; head: bottomHead at the lower border",
                     .defaultText = "free",
                     .choices = kBottoms},
    ConfigurationKey{.name = "bottomHead",
                     .description = "pressure head at the lower border",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = kMostBorderHead},
    ConfigurationKey{.name = "wiltingHead",
                     .description = "pressure head down to which roots can take water; the default is converted from "
                                    "metres",
                     .unit = "length",
                     .minimum = -kMostHead,
                     .maximum = 0.0,
                     .defaultNumber = -150.0},
    ConfigurationKey{.name = "solutes",
                     .kind = KeyKind::Rows,
                     .description =
                         "initial concentration and that of the rain (amount/length³ of water), diffusivity in "
                         "water (length²/day), dispersivity (length), sorbed amount per volume of soil over the "
                         "concentration (1), decay (1/day)",
                     .minimum = 0.0,
                     .minimumCount = 6,
                     .maximumCount = 6},
    ConfigurationKey{.name = "solutesEnter",
                     .kind = KeyKind::Choice,
                     .description = "flow: with the rain only; concentration: the surface keeps the rain's "
                                    "concentration, and solutes spread from it",
                     .defaultText = "flow",
                     .choices = kEntries},
    ConfigurationKey{.name = "acidity",
                     .kind = KeyKind::Boolean,
                     .description = "carry H⁺ with the water, buffered by the soil, and answer its pH"},
    ConfigurationKey{.name = "initialPh",
                     .description = "initial pH",
                     .unit = "1",
                     .minimum = 0.0,
                     .maximum = 14.0,
                     .defaultNumber = 6.5},
    ConfigurationKey{.name = "rainPh",
                     .description = "pH of the rain",
                     .unit = "1",
                     .minimum = 0.0,
                     .maximum = 14.0,
                     .defaultNumber = 5.6},
    ConfigurationKey{.name = "bufferCapacity",
                     .description = "amount of H⁺ that lowers the pH of a volume of soil by 1; the default is "
                                    "converted from metres",
                     .unit = "mol/length^3",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 20.0},
    ConfigurationKey{.name = "protonDiffusivity",
                     .description = "diffusivity of H⁺ in water; the default is converted from metres",
                     .unit = "length^2/day",
                     .minimum = 0.0,
                     .defaultNumber = 8.04e-4},
    ConfigurationKey{.name = "dispersivity", .description = "dispersivity of H⁺", .unit = "length", .minimum = 0.0},
    ConfigurationKey{
        .name = "tolerance",
        .description = "largest difference of a cell's water content from the content that belongs to its head",
        .minimum = 1e-16,
        .maximum = 0.1,
        .defaultNumber = 1e-6},
    ConfigurationKey{.name = "timeTolerance",
                     .description = "largest error of a cell's water content in one internal time step",
                     .unit = "1",
                     .minimum = 1e-9,
                     .maximum = 0.1,
                     .defaultNumber = 1e-3},
};
constexpr auto kSoilWaterKeys = joinTables(kSoilWaterOwnKeys, kObstacleKeys);

core::Diagnostic wrong(const std::string& sentence, const std::string& hint) {
  return wrongConfiguration("soil-water", sentence, hint);
}

}  // namespace

extern constinit const ProcessEntry kSoilWaterProcess{
    .name = "soil-water",
    .summary = kSoilWaterSummary,
    .source =
        "Celia, Bouloutas & Zarba 1990, A general mass-conservative numerical solution for the unsaturated flow "
        "equation; van Genuchten 1980; Mualem 1976; Millington & Quirk 1961",
    .keys = kSoilWaterKeys,
    .make = makeSoilWater};

int SoilWaterKeys::layerAt(double depth) const {
  double below = 0.0;
  for (std::size_t layer = 0; layer < thicknesses.size(); ++layer) {
    below += thicknesses[layer];
    if (depth < below) {
      return static_cast<int>(layer);
    }
  }
  return static_cast<int>(thicknesses.size());
}

Solute SoilWaterKeys::protons(double litres) const {
  return {.initialConcentration = core::pow(10.0, -initialPh) * litres,
          .rainConcentration = core::pow(10.0, -rainPh) * litres,
          .diffusivity = protonDiffusivity,
          .dispersivity = dispersivity,
          .bufferCapacity = bufferCapacity};
}

SoilWaterKeys readSoilWater(const Configuration& given, const LengthUnit* unit) {
  const Configuration configuration = withDefaultLengths(given, kSoilWaterKeys, unit);
  SoilWaterKeys keys;
  keys.shape = {vectorOf(configuration, "position"), cellsOf(configuration), vectorOf(configuration, "cellSize"),
                configuration.number("growth")};
  const auto function =
      configuration.text("soil") == "gardner" ? SoilLayer::Function::Gardner : SoilLayer::Function::VanGenuchten;
  for (const auto& row : configuration.rows("layers")) {
    keys.thicknesses.push_back(row[0]);
    keys.soils.push_back({row[1], row[2], row[3], row[4], row[5], configuration.number("specificStorage"), function});
  }
  keys.hasOwnLayers = !keys.soils.empty();
  if (keys.hasOwnLayers) {
    keys.thicknesses.pop_back();
  } else {
    SoilLayer loam;  // in metres
    const double metres = unit == nullptr ? 1.0 : unit->metres;
    loam.alpha *= metres;
    loam.conductivity /= metres;
    loam.function = function;
    loam.specificStorage = configuration.number("specificStorage");
    keys.soils.push_back(loam);
  }
  for (const auto& row : configuration.rows("solutes")) {
    keys.solutes.push_back({row[0], row[1], row[2], row[3], row[4], row[5]});
  }
  keys.acidity = configuration.flag("acidity");
  keys.initialPh = configuration.number("initialPh");
  keys.rainPh = configuration.number("rainPh");
  keys.bufferCapacity = configuration.number("bufferCapacity");
  keys.protonDiffusivity = configuration.number("protonDiffusivity");
  keys.dispersivity = configuration.number("dispersivity");
  const std::string& bottom = configuration.text("bottom");
  keys.borders = {.hasTopHead = configuration.text("surface") == "head",
                  .topHead = configuration.number("topHead"),
                  .driestHead = configuration.number("driestHead"),
                  .bottom = bottom == "free"     ? SoilBorders::Bottom::Free
                            : bottom == "closed" ? SoilBorders::Bottom::Closed
                                                 : SoilBorders::Bottom::Head,
                  .bottomHead = configuration.number("bottomHead")};
  const double period = configuration.number("weatherPeriod");
  keys.rain = RateSeries(configuration.rows("rain"), period);
  keys.evaporation = RateSeries(configuration.rows("evaporation"), period);
  keys.evaporatesByWeather = configuration.text("evaporationBy") == "weather";
  keys.groundLight = RateSeries(configuration.rows("groundLight"), period);
  keys.albedo = configuration.number("albedo");
  keys.longWaveLoss = configuration.number("longWaveLoss");
  keys.roughness = configuration.number("roughness");
  keys.windHeight = configuration.number("windHeight");
  keys.airPressure = configuration.number("airPressure");
  keys.initialHead = configuration.number("initialHead");
  keys.initialHeads = configuration.numbers("initialHeads");
  keys.fieldUnit = configuration.text("fieldUnit");
  if (configuration.text("initially") == "waterTable") {
    keys.waterTableDepth = configuration.number("waterTableDepth");
  }
  keys.wiltingHead = configuration.number("wiltingHead");
  keys.hasSurfaceConcentration = configuration.text("solutesEnter") == "concentration";
  keys.tolerances = {configuration.number("tolerance"), configuration.number("timeTolerance")};
  return keys;
}

std::vector<core::Diagnostic> checkSoilWater(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors;
  const std::array<std::size_t, 3> cells = cellsOf(configuration);
  if (auto problem = tooManyCells("soil-water", cells, kSoilWaterMaximumCellCount)) {
    errors.push_back(std::move(*problem));
  }
  const std::size_t cellCount = cells[0] * cells[1] * cells[2];
  const std::size_t heads = configuration.numbers("initialHeads").size();
  if (heads != 0 && heads != cellCount) {
    errors.push_back(
        wrong("'initialHeads' has " + std::to_string(heads) + " numbers for " + std::to_string(cellCount) + " cells",
              "give one for every cell, or none"));
  }
  const auto& layers = configuration.rows("layers");
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const auto& row = layers[i];
    const std::string name = "layers[" + std::to_string(i) + "]";
    if (!(row[1] < row[2] && row[2] <= 1.0)) {
      errors.push_back(wrong(name + " has a residual water content that is not below the saturated one, or one above 1",
                             "a row is thickness, residual content, saturated content, α, n, conductivity"));
    } else if (!(row[3] > 0.0 && row[4] > 1.0 && row[5] > 0.0)) {
      errors.push_back(wrong(name + " needs α and the conductivity above 0 and n above 1",
                             "a row is thickness, residual content, saturated content, α, n, conductivity"));
    } else if (!(row[3] >= kLeastAlpha && row[3] <= kMostAlpha && row[5] <= kMostConductivity)) {
      errors.push_back(wrong(name + " has the α " + numberText(row[3]) + " and the conductivity " + numberText(row[5]) +
                                 "; an α lies from " + numberText(kLeastAlpha) + " to " + numberText(kMostAlpha) +
                                 " and a conductivity is at most " + numberText(kMostConductivity),
                             "α is one over a length and the conductivity a length per day, in the world's unit"));
    } else if (configuration.text("soil") != "gardner" && !(row[4] >= kLeastN && row[4] <= kMostN)) {
      errors.push_back(wrong(name + " has van Genuchten's n " + numberText(row[4]) +
                                 ", and the flow of water is solved for n from " + numberText(kLeastN) + " to " +
                                 numberText(kMostN),
                             "fit the curve with an n in that range, or take \"soil\": \"gardner\""));
    }
  }
  if (configuration.text("evaporationBy") == "weather") {
    const double roughness = configuration.number("roughness");
    if (!(roughness > 0.0 && roughness < configuration.number("windHeight"))) {
      errors.push_back(wrong("'evaporationBy' weather needs a 'roughness' above 0 and below 'windHeight'",
                             "give the aerodynamic roughness of the ground in metres"));
    }
    if (!configuration.rows("evaporation").empty()) {
      errors.push_back(wrong("'evaporation' has rows, and 'evaporationBy' is weather", "leave one of them out"));
    }
  }
  for (const auto& row : configuration.rows("groundLight")) {
    if (row[1] > 1.0) {
      errors.push_back(wrong("'groundLight' has a part above 1", "give the part of the global radiation, from 0 to 1"));
      break;
    }
  }
  for (const std::string key : {"rain", "evaporation", "groundLight"}) {
    const auto& rows = configuration.rows(key);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (!(rows[i - 1][0] < rows[i][0])) {
        errors.push_back(
            wrong("'" + key + "' has day " + numberText(rows[i][0]) + " after day " + numberText(rows[i - 1][0]),
                  "write the rows in the order of their days, each day once"));
      }
    }
    const double period = configuration.number("weatherPeriod");
    if (period > 0.0 && !rows.empty() && rows.back()[0] >= period) {
      errors.push_back(wrong("'" + key + "' has a day beyond the 'weatherPeriod' after which it repeats",
                             "use days from 0 to below the period"));
    }
  }
  return errors;
}

}  // namespace espalier::environment
