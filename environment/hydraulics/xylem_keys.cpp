#include "environment/hydraulics/xylem_keys.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "environment/base/json_text.h"
#include "environment/base/number_text.h"

namespace espalier::environment {

extern const ProcessEntry kSoilWaterProcess;

namespace {

// of heads: far beyond dry soil, and a kilometre of water in millimetres
constexpr double kLowestHead = -1e9;
constexpr double kHighestHead = 1e6;
// far above measured ones, below those whose heads are lost in rounding
constexpr double kMostRadial = 1e6;  // 1/day
constexpr double kMostAxial = 1e15;  // length³/day
constexpr double kMostVessels = 1e9;
constexpr double kWidestVessel = 1e5;  // µm
constexpr std::array<std::string_view, 2> kCollars{"flow", "head"};
constexpr std::array<std::string_view, 2> kLeafKinds{"demand", "stomata"};

constexpr std::array kLeafKeys{
    ConfigurationKey{.name = "leaves",
                     .kind = KeyKind::Choice,
                     .description = "demand: p3 is the water that leaves the plant; stomata: p3 is the area of a leaf, "
                                    "whose water follows from light, air and its head",
                     .defaultText = "demand",
                     .choices = kLeafKinds},
    ConfigurationKey{.name = "stomataConductance",
                     .description = "g_max of open stomata, on a unit of leaf area (Jarvis 1976)",
                     .unit = "m/s",
                     .minimum = 0.0,
                     .defaultNumber = 0.01},
    ConfigurationKey{.name = "cuticleConductance",
                     .description = "conductance of a leaf with closed stomata",
                     .unit = "m/s",
                     .minimum = 0.0},
    ConfigurationKey{.name = "halfPar",
                     .description = "light at which stomata are half open: PAR/(PAR + halfPar); 0: no response",
                     .unit = "umol/(m^2 s)",
                     .minimum = 0.0},
    ConfigurationKey{.name = "halfDeficit",
                     .description = "vapour pressure deficit at which stomata are half open: 1/(1 + VPD/halfDeficit); "
                                    "0: no response",
                     .unit = "kPa",
                     .minimum = 0.0},
    ConfigurationKey{.name = "stomataHead",
                     .description = "pressure head of a leaf at which stomata are half open; 0: no response; the "
                                    "default is converted from metres",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = 0.0,
                     .defaultNumber = -100.0},
    ConfigurationKey{.name = "stomataShape",
                     .description = "exponent s of that response, 1/(1 + (head/stomataHead)^s)",
                     .minimum = 0.1,
                     .maximum = 50.0,
                     .defaultNumber = 3.0},
    ConfigurationKey{.name = "leafWidth",
                     .description = "width of a leaf along the wind, for its boundary layer",
                     .unit = "m",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.03},
    ConfigurationKey{.name = "boundaryConductance",
                     .description = "conductance of the boundary layer; 0: by leafWidth and wind",
                     .unit = "m/s",
                     .minimum = 0.0},
    ConfigurationKey{.name = "temperature",
                     .description = "of the air; the weather's takes its place",
                     .unit = "degC",
                     .minimum = -60.0,
                     .maximum = 70.0,
                     .defaultNumber = 20.0},
    ConfigurationKey{.name = "humidity",
                     .description = "relative, of the air; the weather's takes its place",
                     .unit = "%",
                     .minimum = 0.0,
                     .maximum = 100.0,
                     .defaultNumber = 60.0},
    ConfigurationKey{.name = "wind",
                     .description = "speed of the air at the leaves; the weather's takes its place",
                     .unit = "m/s",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "pressure",
                     .description = "of the air",
                     .unit = "kPa",
                     .minimum = 20.0,
                     .maximum = 120.0,
                     .defaultNumber = 101.3},
    ConfigurationKey{.name = "saturationCurve",
                     .kind = KeyKind::Boolean,
                     .description = "vapour pressure in a leaf: true: at the temperature of the leaf; false: along the "
                                    "tangent at that of the air, as Penman and Monteith have it"},
    ConfigurationKey{.name = "growthHead",
                     .description = "pressure head of a leaf at which growth ends: 1 − head/growthHead, from 1 to 0 "
                                    "(Lockhart 1965); the default is converted from metres",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = -1e-9,
                     .defaultNumber = -80.0},
};

constexpr std::array kWaterKeys{
    ConfigurationKey{.name = "kr",
                     .description = "radial conductivity of roots",
                     .unit = "1/day",
                     .minimum = 0.0,
                     .maximum = kMostRadial,
                     .defaultNumber = 1.728e-4},
    ConfigurationKey{.name = "krTable",
                     .kind = KeyKind::Rows,
                     .description =
                         "order, age (day) and radial conductivity (1/day), by order and then by age; linear "
                         "between rows; none: kr",
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "kx",
                     .description = "axial conductance of roots and stems; the default is converted from metres",
                     .unit = "length^3/day",
                     .minimum = 0.0,
                     .maximum = kMostAxial,
                     .isMinimumExclusive = true,
                     .defaultNumber = 4.32e-8},
    ConfigurationKey{.name = "kxTable",
                     .kind = KeyKind::Rows,
                     .description = "order, age (day) and axial conductance (length^3/day), as krTable; none: kx",
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "vessels",
                     .kind = KeyKind::Rows,
                     .description = "in place of kx: order, age (day), number of vessels and their radius (µm), as "
                                    "krTable; their conductance is that of Hagen and Poiseuille, at 20 °C",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{.name = "radius",
                     .description = "radius of all segments; 0: half the width that the model sets for the segment",
                     .unit = "length",
                     .minimum = 0.0,
                     .maximum = 1e6},
    ConfigurationKey{.name = "join",
                     .description = "distance within which the start of a segment is joined to the end of another; 0: "
                                    "they are the same point",
                     .unit = "length",
                     .minimum = 0.0},
    ConfigurationKey{.name = "groundHeight",
                     .description = "height of the ground: segments whose middle is above it take up nothing",
                     .unit = "length"},
    ConfigurationKey{.name = "soilHead",
                     .description = "pressure head of the soil when there is no 'soil'; the default is converted from "
                                    "metres",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = kHighestHead,
                     .defaultNumber = -1.0},
    ConfigurationKey{.name = "soilHeads",
                     .kind = KeyKind::Rows,
                     .description = "height and pressure head of the soil (length), by height; linear between rows; "
                                    "none: soilHead",
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "collar",
                     .kind = KeyKind::Choice,
                     .description = "flow: 'transpiration' leaves each plant at its collars, no more than flows at "
                                    "lowestHead; head: collarHead",
                     .defaultText = "flow",
                     .choices = kCollars},
    ConfigurationKey{.name = "collarHead",
                     .description = "pressure head at the collars; the default is converted from metres",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = kHighestHead,
                     .defaultNumber = -50.0},
    ConfigurationKey{.name = "transpiration",
                     .kind = KeyKind::Rows,
                     .description = "day, flow out of each plant (length^3/day) from then on; none: what queries send",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "transpirationPeriod",
                     .description = "days after which the rows of 'transpiration' repeat; 0: never",
                     .unit = "day",
                     .minimum = 0.0},
    ConfigurationKey{.name = "dayCourse",
                     .kind = KeyKind::Boolean,
                     .description = "the flow follows the hours: times 1 − cos(2π t), t in days, 0 at midnight"},
    ConfigurationKey{.name = "lowestHead",
                     .description = "pressure head below which a collar does not fall when it gives a flow; the "
                                    "default is converted from metres",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = 0.0,
                     .defaultNumber = -150.0},
    ConfigurationKey{.name = "closingHeads",
                     .kind = KeyKind::Numbers,
                     .description = "pressure heads at which leaves begin to close and at which they are closed; none: "
                                    "leaves give what is wanted",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = 0.0,
                     .maximumCount = 2},
    ConfigurationKey{.name = "vulnerabilityHead",
                     .description = "pressure head at which half of kx is lost; 0: nothing is lost",
                     .unit = "length",
                     .minimum = kLowestHead,
                     .maximum = 0.0},
    ConfigurationKey{.name = "vulnerabilityShape",
                     .description = "exponent s of the part that is left: 1/(1 + (head/vulnerabilityHead)^s)",
                     .minimum = 0.1,
                     .maximum = 50.0,
                     .defaultNumber = 3.0},
    ConfigurationKey{.name = "soil",
                     .kind = KeyKind::Entries,
                     .description = "one environment soil-water, whose water the roots take within the step; none: "
                                    "soilHead or soilHeads"},
    ConfigurationKey{.name = "rhizosphere",
                     .kind = KeyKind::Boolean,
                     .description = "the soil around a root resists when it dries (Schröder et al. 2008)",
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "longestStep",
                     .description = "longest internal step of soil and plants together, and of a course of the day",
                     .unit = "day",
                     .minimum = 1e-4,
                     .defaultNumber = 1.0 / 48.0},
    ConfigurationKey{.name = "couplingTolerance",
                     .description =
                         "largest difference between what plants take from a cell and what the cell gives in "
                         "an internal step, as water content",
                     .minimum = 1e-12,
                     .maximum = 0.01,
                     .defaultNumber = 1e-6},
};

constexpr auto kXylemKeys = joinTables(kWaterKeys, kLeafKeys);

core::Diagnostic wrongXylem(const std::string& sentence, std::string hint) {
  return wrongConfiguration("xylem", sentence, std::move(hint));
}

/// An error of the key `soil`: that of soil-water in the name of xylem.
core::Diagnostic ofSoil(core::Diagnostic error) {
  error.message = "environment process 'xylem': in 'soil', " + error.message;
  return error;
}

}  // namespace

extern constinit const ProcessEntry kXylemProcess{
    .name = "xylem",
    .summary = kXylemSummary,
    .source =
        "Landsberg & Fowkes 1978; Meunier et al. 2017, A hybrid analytical-numerical method for solving water flow "
        "equations in root hydraulic architectures; Schröder et al. 2008; Couvreur et al. 2012; Peaceman 1978; Jarvis "
        "1976; Monteith 1965; Lockhart 1965",
    .keys = kXylemKeys,
    .make = makeXylem};

namespace {

LeafKeys readLeafKeys(const Configuration& configuration) {
  LeafKeys keys;
  keys.hasStomata = configuration.text("leaves") == "stomata";
  keys.stomata = {.most = configuration.number("stomataConductance"),
                  .least = configuration.number("cuticleConductance"),
                  .halfPar = configuration.number("halfPar"),
                  .halfDeficit = configuration.number("halfDeficit"),
                  .halfHead = configuration.number("stomataHead"),
                  .shape = configuration.number("stomataShape")};
  keys.isCurve = configuration.flag("saturationCurve");
  keys.width = configuration.number("leafWidth");
  keys.boundary = configuration.number("boundaryConductance");
  keys.temperature = configuration.number("temperature");
  keys.humidity = configuration.number("humidity");
  keys.wind = configuration.number("wind");
  keys.pressure = configuration.number("pressure");
  keys.growthHead = configuration.number("growthHead");
  keys.hasOwnStomataHead = configuration.isGiven("stomataHead");
  keys.hasOwnGrowthHead = configuration.isGiven("growthHead");
  return keys;
}

}  // namespace

namespace {

/// The rows of `vessels` as order, age and conductance in m³/day.
ConfigurationRows conductancesOf(const ConfigurationRows& vessels) {
  ConfigurationRows rows;
  for (const auto& row : vessels) {
    rows.push_back({row[0], row[1], vesselConductance(row[2], row[3] * 1e-6)});
  }
  return rows;
}

}  // namespace

XylemKeys readXylem(const Configuration& configuration) {
  XylemKeys keys;
  keys.leafGas = readLeafKeys(configuration);
  keys.radial = ConductivityTable(configuration.number("kr"), configuration.rows("krTable"));
  keys.axial = ConductivityTable(configuration.number("kx"), configuration.rows("kxTable"));
  keys.hasOwnAxial = configuration.isGiven("kx") || !configuration.rows("kxTable").empty();
  if (const auto& vessels = configuration.rows("vessels"); !vessels.empty()) {
    keys.axial = ConductivityTable(0.0, conductancesOf(vessels));
    keys.hasOwnAxial = false;  // converted from metres
  }
  keys.radius = configuration.number("radius");
  keys.join = configuration.number("join");
  keys.groundHeight = configuration.number("groundHeight");
  keys.soilHeads = configuration.rows("soilHeads");
  keys.soilHead = configuration.number("soilHead");
  keys.hasOwnSoilHead = configuration.isGiven("soilHead");
  keys.hasCollarHead = configuration.text("collar") == "head";
  keys.collarHead = configuration.number("collarHead");
  keys.hasOwnCollarHead = configuration.isGiven("collarHead");
  keys.lowestHead = configuration.number("lowestHead");
  keys.hasOwnLowestHead = configuration.isGiven("lowestHead");
  keys.transpiration = RateSeries(configuration.rows("transpiration"), configuration.number("transpirationPeriod"));
  keys.hasDayCourse = configuration.flag("dayCourse");
  keys.changesInTime = keys.hasDayCourse || configuration.rows("transpiration").size() > 1;
  if (const auto& heads = configuration.numbers("closingHeads"); !heads.empty()) {
    keys.leaves = {.canClose = true, .open = heads[0], .closed = heads[1]};
  }
  keys.vessels = {configuration.number("vulnerabilityHead"), configuration.number("vulnerabilityShape")};
  keys.hasRhizosphere = configuration.flag("rhizosphere");
  keys.limits = {configuration.number("longestStep"), configuration.number("couplingTolerance")};
  return keys;
}

std::vector<core::Diagnostic> checkXylem(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors;
  const auto& vessels = configuration.rows("vessels");
  for (const std::string key : {"krTable", "kxTable", "vessels"}) {
    const ConfigurationRows rows = key == "vessels" ? conductancesOf(vessels) : configuration.rows(key);
    const auto negative =
        std::find_if(vessels.begin(), vessels.end(), [](const auto& row) { return row[2] < 0.0 || row[3] < 0.0; });
    if (key == "vessels" && negative != vessels.end()) {
      errors.push_back(wrongXylem("'vessels' has " + numberText((*negative)[2]) + " vessels of the radius " +
                                      numberText((*negative)[3]) + " in row " +
                                      std::to_string(negative - vessels.begin()) + ", which is below 0",
                                  "write rows of order, age, number of vessels and their radius in µm, both above 0"));
      continue;
    }
    if (const std::string problem = ConductivityTable::problemOf(rows); !problem.empty()) {
      errors.push_back(wrongXylem("'" + key + "' " + problem,
                                  key == "vessels" ? "write rows of order, age, number and radius of vessels, by order "
                                                     "and then by age"
                                                   : "write rows of order, age and conductivity, by order and then by "
                                                     "age"));
    }
    const double most = key == "krTable" ? kMostRadial : kMostAxial;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (key == "vessels" && !(vessels[i][2] <= kMostVessels && vessels[i][3] <= kWidestVessel)) {
        errors.push_back(wrongXylem("'vessels' has " + numberText(vessels[i][2]) + " vessels of the radius " +
                                        numberText(vessels[i][3]) + " in row " + std::to_string(i) +
                                        ", and there are at most " + numberText(kMostVessels) + " of at most " +
                                        numberText(kWidestVessel) + " µm",
                                    "write rows of order, age, number of vessels and their radius in µm"));
      } else if (key != "vessels" && rows[i][2] > most) {
        errors.push_back(wrongXylem("'" + key + "' has " + numberText(rows[i][2]) + " in row " + std::to_string(i) +
                                        ", and the most is " + numberText(most),
                                    "write rows of order, age and conductivity, in the world's length unit and days"));
      }
    }
    for (std::size_t i = 0; key != "krTable" && i < rows.size(); ++i) {
      if (!(rows[i][2] > 0.0) || (key == "vessels" && !(vessels[i][2] > 0.0 && vessels[i][3] > 0.0))) {
        errors.push_back(wrongXylem("'" + key + "' has the conductance 0 in row " + std::to_string(i),
                                    "water must be able to flow along a root: write a number above 0"));
      }
    }
  }
  for (const std::string key : {"kx", "kxTable"}) {
    if (!vessels.empty() && configuration.isGiven(key)) {
      errors.push_back(wrongXylem("'vessels' and '" + key + "' both say what the xylem conducts", "give one of them"));
    }
  }
  for (const auto& [key, what] :
       {std::pair<std::string, std::string>{"soilHeads", "height"}, {"transpiration", "day"}}) {
    const auto& rows = configuration.rows(key);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (!(rows[i - 1][0] < rows[i][0])) {
        errors.push_back(wrongXylem("'" + key + "' has " + what + " " + numberText(rows[i][0]) + " after " + what +
                                        " " + numberText(rows[i - 1][0]),
                                    "write the rows in ascending order, each " + what + " once"));
      }
    }
  }
  for (const auto& row : configuration.rows("soilHeads")) {
    if (!(row[1] >= kLowestHead && row[1] <= kHighestHead)) {
      errors.push_back(wrongXylem("'soilHeads' has the head " + numberText(row[1]) + ", and heads lie from " +
                                      numberText(kLowestHead) + " to " + numberText(kHighestHead),
                                  "write rows of height and pressure head, in the world's length unit"));
      break;
    }
  }
  const auto& heads = configuration.numbers("closingHeads");
  if (!heads.empty() && configuration.text("leaves") == "stomata") {
    errors.push_back(wrongXylem("'closingHeads' belongs to leaves of the kind 'demand', and 'leaves' is 'stomata'",
                                "write 'stomataHead' and 'stomataShape' in place of 'closingHeads'"));
  }
  if (heads.size() == 1 || (heads.size() == 2 && !(heads[0] > heads[1]))) {
    errors.push_back(wrongXylem("'closingHeads' must be two heads, the second one lower",
                                "write the head at which leaves begin to close, then that at which they are closed"));
  }
  return errors;
}

tl::expected<std::optional<SoilBody>, std::vector<core::Diagnostic>> readXylemSoil(const Configuration& configuration) {
  const std::vector<std::string>& entries = configuration.entries("soil");
  if (entries.empty()) {
    return std::optional<SoilBody>();
  }
  const std::string hint = R"(write "soil": [{"type": "soil-water", …}])";
  auto object = parseJson(entries.front(), "soil");
  if (entries.size() > 1 || !object || !object->is_object() ||
      object->value("type", nlohmann::json()) != "soil-water") {
    return tl::unexpected(std::vector{wrongXylem("'soil' must be one environment of the type soil-water", hint)});
  }
  object->erase("type");
  object->erase("name");
  auto read = readConfiguration("soil-water", kSoilWaterProcess.keys, object->dump());
  std::vector<core::Diagnostic> errors;
  if (!read) {
    for (ConfigurationError& error : read.error()) {
      errors.push_back(ofSoil(std::move(error.diagnostic)));
    }
    return tl::unexpected(std::move(errors));
  }
  auto body = makeSoilBody(*read);
  if (!body) {
    for (core::Diagnostic& error : body.error()) {
      errors.push_back(ofSoil(std::move(error)));
    }
    return tl::unexpected(std::move(errors));
  }
  return std::optional<SoilBody>(std::move(*body));
}

}  // namespace espalier::environment
