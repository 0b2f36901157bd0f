#include "environment/soil/soil_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/weather.h"
#include "environment/base/air.h"
#include "environment/base/length_unit.h"
#include "environment/base/number_text.h"
#include "environment/geometry/world_up.h"

namespace espalier::environment {

namespace {
constexpr double kMostHeightRatio = 1e5;  // of cells
constexpr double kDry = 1e-6;             // effective saturation below which a soil has next to no water
}  // namespace

std::optional<turtle::EnvironmentError> SoilBody::open(std::string_view process, const turtle::World& world) {
  const auto fail = [&](const std::string& sentences) {
    return turtle::EnvironmentError{"Environment '" + std::string(process) + "' " + sentences, false};
  };
  const auto axes = gridAxesOf(process, world);
  if (!axes) {
    return axes.error();
  }
  if (!(world.stepDurationDays > 0.0)) {
    return fail("lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.");
  }
  const LengthUnit* unit = findLengthUnit(world.lengthUnit);
  keys_ = readSoilWater(given_, unit);
  const auto layers = static_cast<double>(keys_.shape.cells[static_cast<std::size_t>(axes->up)]);
  const double growth = std::max(keys_.shape.growth, 1.0 / keys_.shape.growth);
  if (core::pow(growth, layers - 1.0) > kMostHeightRatio) {
    return fail(
        "has 'growth' " + numberText(keys_.shape.growth) + " and " + numberText(layers) +
        " layers of cells: the highest cell would be more than 100000 times as high as the lowest, and the flow "
        "of water is not solved then. Use fewer layers, or a 'growth' nearer to 1.");
  }
  if (unit == nullptr && !keys_.hasOwnLayers) {
    return fail("has a default soil in metres, and the world's unit is '" + world.lengthUnit +
                "'. Give 'layers', or set lengthUnit to m, dm, cm or mm.");
  }
  if (!keys_.fieldUnit.empty() && keys_.fieldUnit != world.lengthUnit) {
    return fail("begins with pressure heads in '" + keys_.fieldUnit + "', and the world's unit of length is '" +
                world.lengthUnit + "'. Give the heads and the places of their cells in " + world.lengthUnit + ".");
  }
  if (keys_.acidity && unit == nullptr) {
    return unknownLengthUnit(process, world);
  }
  hasRain_ = world.weather && world.weather->has("rain");
  for (const std::string_view quantity : quantitiesOfWeather()) {
    if (unit == nullptr) {
      return unknownLengthUnit(process, world);
    }
    if (!world.weather || !world.weather->has(quantity)) {
      return fail("has 'evaporationBy' weather, and the world's weather has no '" + std::string(quantity) +
                  "'. Give the world a weather with global, temperature, humidity and wind, or 'evaporation' rows.");
    }
  }
  perMillimetre_ = unit == nullptr ? 0.0 : 1e-3 / unit->metres;
  world_ = world;
  litres_ = unit == nullptr ? 0.0 : unit->litres;
  lengthUnit_ = world.lengthUnit;
  ground_ = Ground(keys_.shape, *axes);
  fill();
  return std::nullopt;
}

void SoilBody::fill() {
  const RichardsSolver::Shape shape = ground_.solverShape();
  const std::size_t count = shape.columns[0] * shape.columns[1] * shape.layers;
  std::vector<int> soilOf(count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    soilOf[cell] =
        stones_.isEmpty() || !stones_.isInside(ground_.middleOf(cell)) ? keys_.layerAt(ground_.depthOf(cell)) : -1;
  }
  water_.emplace(shape, keys_.soils, std::move(soilOf));
  for (std::size_t cell = 0; cell < count; ++cell) {
    water_->setHead(cell, !keys_.initialHeads.empty() ? keys_.initialHeads[ground_.fieldIndexOf(cell)]
                          : keys_.waterTableDepth     ? ground_.depthOf(cell) - *keys_.waterTableDepth
                                                      : keys_.initialHead);
  }
  std::vector<Solute> solutes = keys_.solutes;
  if (keys_.acidity) {
    solutes.push_back(keys_.protons(litres_));
  }
  solutes_.emplace(std::move(solutes), *water_, keys_.hasSurfaceConcentration);
  contentsBefore_.assign(count, 0.0);
  day_ = 0.0;
}

std::optional<std::size_t> SoilBody::cellOf(const core::Vec3& point) const {
  const auto cell = ground_.cellOf(point);
  return cell && water_->isSoil(*cell) ? cell : std::nullopt;
}

double SoilBody::phOf(std::size_t cell) const {
  // roots that take up more than is there leave none: the scale ends at 14
  constexpr double kLeast = 1e-14;  // mol/L
  const double concentration = solutes_->concentration(keys_.solutes.size(), cell, water_->contentOf(cell)) / litres_;
  return -core::log10(std::max(concentration, kLeast));
}

std::vector<std::string_view> SoilBody::quantitiesOfWeather() const {
  std::vector<std::string_view> quantities;
  if (hasRain_) {
    quantities.emplace_back("rain");
  }
  if (keys_.evaporatesByWeather) {
    quantities.insert(quantities.end(), {"global", "temperature", "humidity", "wind"});
  }
  return quantities;
}

/// The mean of a quantity over the hour from a day on; shortens `until` to the days for which it holds.
double SoilBody::meanOfHour(std::string_view quantity, double day, double& until) const {
  // a time just before a full hour belongs to the next one
  const double hour = std::floor(day * 24.0 + 1e-9);
  until = std::min(until, (hour + 1.0) / 24.0 - day);
  const double begin = std::max(hour / 24.0, std::min(world_.weather->begin(), day));
  const double end = std::min((hour + 1.0) / 24.0, std::max(world_.weather->end(), day));
  return world_.weather->mean(quantity, begin, end).value_or(0.0);
}

/// The rain from a day on, length/day; shortens `until` to the days for which it holds.
double SoilBody::rainFrom(double day, double& until) const {
  if (!hasRain_) {
    until = std::min(until, keys_.rain.remaining(day));
    return keys_.rain.at(day);
  }
  return 24.0 * perMillimetre_ * meanOfHour("rain", day, until);
}

/// The potential evaporation from a day on, length/day; shortens `until` as well.
double SoilBody::evaporationFrom(double day, double& until) const {
  if (!keys_.evaporatesByWeather) {
    until = std::min(until, keys_.evaporation.remaining(day));
    return keys_.evaporation.at(day);
  }
  constexpr double kSecondsPerDay = 86400.0;
  double part = 1.0;
  if (!keys_.groundLight.isEmpty()) {
    until = std::min(until, keys_.groundLight.remaining(day));
    part = keys_.groundLight.at(day);
  }
  Air air{.temperature = meanOfHour("temperature", day, until), .pressure = keys_.airPressure};
  air.vapourPressure = 0.01 * meanOfHour("humidity", day, until) * saturationPressure(air.temperature);
  const double energy = (1.0 - keys_.albedo) * part * meanOfHour("global", day, until) - keys_.longWaveLoss;
  const double conductance = airConductance(meanOfHour("wind", day, until), keys_.windHeight, keys_.roughness);
  // kg/m² are millimetres; dew is left out
  return std::max(wetSurfaceEvaporation(air, energy, conductance), 0.0) * kSecondsPerDay * perMillimetre_;
}

std::optional<turtle::EnvironmentError> SoilBody::problemOfWeather(std::string_view process, double days) const {
  for (const std::string_view quantity : quantitiesOfWeather()) {
    if (!world_.weather->mean(quantity, day_, day_ + days)) {
      return turtle::EnvironmentError{
          "Environment '" + std::string(process) + "' " + turtle::missingWeather(world_, quantity, day_, day_ + days),
          false};
    }
  }
  return std::nullopt;
}

double SoilBody::advance(double days, RichardsSolver::Uptake* uptake, double tolerance) {
  SoilBorders borders = keys_.borders;
  double until = days;
  borders.evaporation = evaporationFrom(day_, until);
  borders.rain = rainFrom(day_, until);
  for (std::size_t cell = 0; cell < contentsBefore_.size(); ++cell) {
    contentsBefore_[cell] = water_->contentOf(cell);
  }
  // weather that ends within rounding has ended
  RichardsSolver::Tolerance tolerances = keys_.tolerances;
  tolerances.iteration = std::min(tolerances.iteration, tolerance);
  areSolutesTooFast_ = false;
  const double passed =
      water_->advance(std::max(until, 1e-12 * std::max(1.0, day_ + days)), borders, tolerances, uptake);
  if (passed > 0.0) {
    areSolutesTooFast_ = !solutes_->follow(passed, contentsBefore_);
    if (areSolutesTooFast_) {
      return 0.0;
    }
    day_ += passed;
  }
  return passed;
}

std::optional<turtle::EnvironmentError> SoilBody::passTime(double days) {
  if (auto problem = problemOfWeather("soil-water", days)) {
    return problem;
  }
  beginStep(days);
  const double end = turtle::endOfStep(day_, days);
  while (end - day_ > 1e-12 * std::max(1.0, end)) {
    core::pollWork();
    if (!(advance(end - day_) > 0.0)) {
      return turtle::EnvironmentError{"Environment 'soil-water' " + problemOfFlow(), false};
    }
  }
  day_ = end;
  return std::nullopt;
}

std::string SoilBody::problemOfFlow() const {
  if (areSolutesTooFast_) {
    return "would take minutes for a step to follow its solutes: they spread too fast for its cells. Give a smaller "
           "diffusivity or dispersivity, larger cells, or shorter steps.";
  }
  const std::size_t cell = water_->lastCell();
  const core::Vec3 place = ground_.middleOf(cell);
  const double head = water_->state().heads[cell];
  std::string problem = "finds no solution of the flow of water on day " + numberText(day_) + " at (" +
                        numberText(place.x) + ", " + numberText(place.y) + ", " + numberText(place.z) +
                        "), where the pressure head is " + numberText(head) + " " + lengthUnit_ + ": the residual is " +
                        numberText(water_->lastResidual()) + " of the water content, the tolerance " +
                        numberText(keys_.tolerances.iteration) + ". ";
  // a front that enters such soil is what has no solution, and it may be in the cell before
  for (std::size_t dry = 0; dry < water_->cellCount(); ++dry) {
    if (water_->isSoil(dry) && water_->soilOf(dry).saturation(water_->state().heads[dry]) < kDry) {
      const SoilLayer& soil = water_->soilOf(dry);
      const core::Vec3 there = ground_.middleOf(dry);
      return problem + "The soil at (" + numberText(there.x) + ", " + numberText(there.y) + ", " + numberText(there.z) +
             ") has next to no water (α " + numberText(soil.alpha) + ", n " + numberText(soil.n) +
             "): begin with heads of " + numberText(soil.headAtSaturation(kDry)) + " " + lengthUnit_ +
             " or higher, or give its layer a smaller n.";
    }
  }
  return problem + "Use larger cells, a larger 'tolerance', or less extreme weather and layers.";
}

std::vector<turtle::Field> SoilBody::fields() const {
  if (!water_) {
    return {};
  }
  std::vector<turtle::Field> fields;
  const auto add = [&](const std::string& name, const std::string& unit, const auto& value) {
    fields.push_back(
        ground_.field(name, unit, [&](std::size_t cell) { return water_->isSoil(cell) ? value(cell) : 0.0; }));
  };
  add("waterContent", "1", [&](std::size_t cell) { return water_->contentOf(cell); });
  add("pressureHead", lengthUnit_, [&](std::size_t cell) { return water_->state().heads[cell]; });
  for (std::size_t solute = 0; solute < keys_.solutes.size(); ++solute) {
    add("solute" + std::to_string(solute + 1), "1/" + lengthUnit_ + "^3",
        [&](std::size_t cell) { return solutes_->concentration(solute, cell, water_->contentOf(cell)); });
  }
  if (keys_.acidity) {
    add("pH", "1", [&](std::size_t cell) { return phOf(cell); });
  }
  addBalance(fields);
  return fields;
}

void SoilBody::addBalance(std::vector<turtle::Field>& fields) const {
  const RichardsSolver::Shape& shape = water_->shape();
  const double base = shape.cellSize[0] * shape.cellSize[1] * static_cast<double>(shape.columns[0] * shape.columns[1]);
  const RichardsSolver::Balance& balance = water_->state().balance;
  // one cell as large as the box
  turtle::Field whole;
  whole.unit = lengthUnit_;
  whole.position = fields.front().position;
  const auto& counts = fields.front().cells;
  const core::Vec3& size = fields.front().cellSize;
  whole.cellSize = {size.x * static_cast<double>(counts[0]), size.y * static_cast<double>(counts[1]),
                    size.z * static_cast<double>(counts[2])};
  for (const auto& [name, amount] : {std::pair{"storedWater", water_->storedWater()},
                                     {"infiltrated", balance.infiltrated},
                                     {"drained", balance.drained},
                                     {"runOff", balance.runOff}}) {
    whole.name = name;
    whole.values = {amount / base};
    fields.push_back(whole);
  }
}

std::vector<double> SoilBody::numbers() const {
  std::vector<double> all;
  if (!water_) {
    return all;
  }
  const RichardsSolver::State& state = water_->state();
  all = {day_, state.timeStep, state.balance.infiltrated, state.balance.drained, state.balance.runOff};
  all.insert(all.end(), state.heads.begin(), state.heads.end());
  all.insert(all.end(), state.contents.begin(), state.contents.end());
  all.insert(all.end(), state.rates.begin(), state.rates.end());
  for (std::size_t solute = 0; solute < solutes_->soluteCount(); ++solute) {
    all.insert(all.end(), solutes_->amounts(solute).begin(), solutes_->amounts(solute).end());
    all.push_back(solutes_->balances()[solute].left);
    all.push_back(solutes_->balances()[solute].decayed);
  }
  return all;
}

void SoilBody::setNumbers(const std::vector<double>& all) {
  if (!water_) {
    return;
  }
  auto from = all.begin();
  RichardsSolver::State& state = water_->state();
  for (double* number :
       {&day_, &state.timeStep, &state.balance.infiltrated, &state.balance.drained, &state.balance.runOff}) {
    *number = *from++;
  }
  const auto read = [&](std::vector<double>& numbers) {
    std::copy_n(from, numbers.size(), numbers.begin());
    from += static_cast<std::ptrdiff_t>(numbers.size());
  };
  read(state.heads);
  read(state.contents);
  read(state.rates);
  for (std::size_t solute = 0; solute < solutes_->soluteCount(); ++solute) {
    read(solutes_->amounts(solute));
    solutes_->balances()[solute].left = *from++;
    solutes_->balances()[solute].decayed = *from++;
  }
}

tl::expected<SoilBody, std::vector<core::Diagnostic>> makeSoilBody(const Configuration& configuration) {
  auto read = readObstacles("soil-water", configuration);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  if (auto errors = checkSoilWater(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return SoilBody(ObstacleScene(std::move(*read)), configuration);
}

}  // namespace espalier::environment
