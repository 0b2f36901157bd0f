// The process `soil-water` (docs/environments.md): water in unsaturated ground with solutes and acidity, and roots that
// take them up.
//
// Richards' equation with van Genuchten's functions by layer (richards.h), any number of solutes and buffered H⁺
// (solutes.h), stones, rain and evaporation. All queries see the state of the step before; when they want more than a
// cell holds, each gets the same share of what it wants. Sums are sorted. The obtained amounts leave the cells evenly
// while the step's time passes. O(n log n + cells · time steps · iterations).

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "environment/base/length_unit.h"
#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/world_up.h"
#include "environment/obstacles/obstacle_scene.h"
#include "environment/soil/ground.h"
#include "environment/soil/soil_water_keys.h"
#include "environment/soil/solutes.h"

namespace espalier::environment {

namespace {

using core::Vec3;

/// The wishes of the queries of one cell, settled in shares that do not depend on their order.
struct Demand {
  std::size_t cell;
  double wanted;
  std::size_t query;
};

class SoilWater final : public turtle::EnvironmentProcess {
 public:
  SoilWater(ObstacleScene stones, const Configuration& configuration)
      : stones_(std::move(stones)), keys_(readSoilWater(configuration)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string& unit = lengthUnit_;
    turtle::EnvironmentDescription description{.name = "soil-water",
                                               .summary = std::string(kSoilWaterSummary),
                                               .needs = {.position = true, .parameters = true},
                                               .inputs = {{"waterWanted", unit + "^3", ""},
                                                          {"unused2", "1", ""},
                                                          {"unused3", "1", ""},
                                                          {"unused4", "1", ""},
                                                          {"unused5", "1", ""},
                                                          {"unused6", "1", ""},
                                                          {"protonsGivenOff", "mol", ""}},
                                               .outputs = {{"waterObtained", unit + "^3", ""},
                                                           {"pressureHead", unit, ""},
                                                           {"waterContent", "1", ""},
                                                           {"gradientX", "1/" + unit, ""},
                                                           {"gradientY", "1/" + unit, ""},
                                                           {"gradientZ", "1/" + unit, ""},
                                                           {"pH", "1", ""}},
                                               .isStateful = true};
    for (std::size_t k = 1; k <= keys_.solutes.size(); ++k) {
      const std::string number = std::to_string(k);
      description.inputs.push_back({"solute" + number + "Wanted", "1", ""});
      description.inputs.push_back({"unused" + std::to_string(7 + 2 * k), "1", ""});
      description.outputs.push_back({"solute" + number + "Obtained", "1", ""});
      description.outputs.push_back({"solute" + number + "Concentration", "1/" + unit + "^3", ""});
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("soil-water", context.world);
    if (!axes) {
      return axes.error();
    }
    if (!(context.world.stepDurationDays > 0.0)) {
      return turtle::EnvironmentError{
          "Environment 'soil-water' lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.",
          false};
    }
    if (context.world.lengthUnit != "m" && !keys_.hasOwnLayers) {
      return turtle::EnvironmentError{
          "Environment 'soil-water' has a default soil in metres, and the world's unit is '" +
              context.world.lengthUnit + "'. Give 'layers', or set lengthUnit to m.",
          false};
    }
    const LengthUnit* unit = findLengthUnit(context.world.lengthUnit);
    if (keys_.acidity && unit == nullptr) {
      return unknownLengthUnit("soil-water", context.world);
    }
    litres_ = unit == nullptr ? 0.0 : unit->litres;
    lengthUnit_ = context.world.lengthUnit;
    days_ = context.world.stepDurationDays;
    ground_ = Ground(keys_.shape, *axes);
    fill();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    return orGoBack([&](const std::vector<double>& before) {
      answerState(queries, replies);
      takeUp(queries, replies);
      countAnswers(queries, replies);
      return passTime(before);
    });
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    return orGoBack([this](const std::vector<double>& before) {
      std::fill(water_->sinks().begin(), water_->sinks().end(), 0.0);
      return passTime(before);
    });
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
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
    return fields;
  }

  [[nodiscard]] std::string save() const override { return saveNumbers(numbers()); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    std::vector<double> read = numbers();
    if (auto error = restoreNumbers(state, "soil-water", read)) {
      return error;
    }
    setNumbers(read);
    return std::nullopt;
  }

 private:
  /// Advances; on an exception everything is as before.
  template <typename Advance>
  [[nodiscard]] std::optional<turtle::EnvironmentError> orGoBack(const Advance& advance) {
    const std::vector<double> before = numbers();
    try {
      return advance(before);
    } catch (...) {
      setNumbers(before);
      throw;
    }
  }

  /// Everything as it is at first.
  void fill() {
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
    day_ = 0.0;
  }

  void answerState(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) const {
    const auto contentOf = [&](std::size_t cell) { return water_->contentOf(cell); };
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = std::min(queries.parametersOf(query).size(), 7 + 2 * keys_.solutes.size());
      const auto cell = soilCellOf(queries.position[query]);
      std::vector<double> values(7 + 2 * keys_.solutes.size(), 0.0);
      if (cell && count > 1) {
        const double content = water_->contentOf(*cell);
        const Vec3 gradient = ground_.gradientAt(*cell, *water_, contentOf);
        values[1] = water_->state().heads[*cell];
        values[2] = content;
        values[3] = gradient.x;
        values[4] = gradient.y;
        values[5] = gradient.z;
        values[6] = keys_.acidity ? phOf(*cell) : 0.0;
        for (std::size_t solute = 0; solute < keys_.solutes.size(); ++solute) {
          values[8 + 2 * solute] = solutes_->concentration(solute, *cell, content);
        }
      }
      for (std::size_t k = 0; k < count; ++k) {
        replies.set(queries, query, k, values[k]);
      }
    }
  }

  /// Settles the wishes in parameter k of the queries: `limits(cell)` are the amounts that a cell can give and take in;
  /// `take` removes the obtained amount from a cell.
  template <typename Limits, typename Take>
  void settle(const turtle::QueryBatch& queries, std::size_t k, const Limits& limits, const Take& take,
              turtle::ReplyBatch& replies) {
    std::vector<Demand> demands;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (k < parameters.size() && parameters[k] != 0.0) {
        if (const auto cell = soilCellOf(queries.position[query])) {
          demands.push_back({*cell, parameters[k], query});
        }
      }
    }
    // sorted, the sums of a cell are the same for any order of queries
    std::sort(demands.begin(), demands.end(),
              [](const Demand& a, const Demand& b) { return std::tie(a.cell, a.wanted) < std::tie(b.cell, b.wanted); });
    for (std::size_t begin = 0; begin < demands.size();) {
      double wanted = 0.0;
      double offered = 0.0;
      std::size_t end = begin;
      for (; end < demands.size() && demands[end].cell == demands[begin].cell; ++end) {
        (demands[end].wanted > 0.0 ? wanted : offered) += std::abs(demands[end].wanted);
      }
      const auto [available, room] = limits(demands[begin].cell);
      const double giving = wanted > available ? available / wanted : 1.0;
      const double taking = offered > room ? room / offered : 1.0;
      for (std::size_t i = begin; i < end; ++i) {
        replies.set(queries, demands[i].query, k, demands[i].wanted * (demands[i].wanted > 0.0 ? giving : taking));
      }
      take(demands[begin].cell, wanted * giving - offered * taking);
      begin = end;
    }
  }

  void takeUp(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) {
    std::fill(water_->sinks().begin(), water_->sinks().end(), 0.0);
    constexpr double kNoLimit = 1e300;
    // solutes first: their concentrations are those of the water that was there
    for (std::size_t solute = 0; solute < keys_.solutes.size(); ++solute) {
      settle(
          queries, 7 + 2 * solute,
          [&](std::size_t cell) {
            return std::pair(std::max(solutes_->amounts(solute)[cell], 0.0) * water_->cellVolume(cell), kNoLimit);
          },
          [&](std::size_t cell, double amount) {
            solutes_->amounts(solute)[cell] -= amount / water_->cellVolume(cell);
          },
          replies);
    }
    if (keys_.acidity) {
      giveOffProtons(queries);
    }
    settle(
        queries, 0,
        [&](std::size_t cell) {
          const SoilLayer& soil = water_->soilOf(cell);
          const double content = water_->contentOf(cell);
          const double volume = water_->cellVolume(cell);
          return std::pair(std::max(content - soil.content(keys_.wiltingHead), 0.0) * volume,
                           std::max(soil.saturatedContent - content, 0.0) * volume);
        },
        [&](std::size_t cell, double amount) { water_->sinks()[cell] = amount / days_; }, replies);
  }

  void giveOffProtons(const turtle::QueryBatch& queries) {
    std::vector<std::pair<std::size_t, double>> given;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() > 6 && parameters[6] != 0.0) {
        if (const auto cell = soilCellOf(queries.position[query])) {
          given.emplace_back(*cell, parameters[6]);
        }
      }
    }
    std::sort(given.begin(), given.end());
    for (const auto& [cell, amount] : given) {
      solutes_->amounts(keys_.solutes.size())[cell] += amount / water_->cellVolume(cell);
    }
  }

  [[nodiscard]] double phOf(std::size_t cell) const {
    // roots that take up more than is there leave none: the scale ends at 14
    constexpr double kLeast = 1e-14;  // mol/L
    const double concentration = solutes_->concentration(keys_.solutes.size(), cell, water_->contentOf(cell)) / litres_;
    return -core::log10(std::max(concentration, kLeast));
  }

  [[nodiscard]] std::optional<std::size_t> soilCellOf(const Vec3& point) const {
    const auto cell = ground_.cellOf(point);
    return cell && water_->isSoil(*cell) ? cell : std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> passTime(const std::vector<double>& backup) {
    const double end = day_ + days_;
    std::vector<double> before(water_->cellCount());
    while (end - day_ > 1e-12 * std::max(1.0, end)) {
      SoilBorders borders = keys_.borders;
      borders.rain = keys_.rain.at(day_);
      borders.evaporation = keys_.evaporation.at(day_);
      const double until = std::min({end - day_, keys_.rain.remaining(day_), keys_.evaporation.remaining(day_)});
      for (std::size_t cell = 0; cell < before.size(); ++cell) {
        before[cell] = water_->contentOf(cell);
      }
      // weather that ends within rounding has ended
      const double days = water_->advance(std::max(until, 1e-12 * std::max(1.0, end)), borders, keys_.tolerances);
      if (!(days > 0.0)) {
        const std::string day = std::to_string(day_);
        setNumbers(backup);
        return turtle::EnvironmentError{
            "Environment 'soil-water' finds no solution of the flow of water on day " + day +
                ". Use larger cells, a larger 'tolerance', or less extreme weather and layers.",
            false};
      }
      solutes_->follow(days, before);
      day_ += days;
    }
    day_ = end;
    return std::nullopt;
  }

  /// The whole state as one list of numbers.
  [[nodiscard]] std::vector<double> numbers() const {
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

  void setNumbers(const std::vector<double>& all) {
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

  ObstacleScene stones_;
  SoilWaterKeys keys_;
  Ground ground_;
  std::optional<RichardsSolver> water_;
  std::optional<SoluteTransport> solutes_;  // those of the configuration, then H⁺ when acidity is on
  double day_ = 0.0;                        // since the beginning
  double days_ = 1.0;                       // of a step
  double litres_ = 1000.0;                  // in a volume of length unit cubed
  std::string lengthUnit_ = "m";
};

}  // namespace

ProcessOrErrors makeSoilWater(const Configuration& configuration) {
  auto read = readObstacles("soil-water", configuration);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  if (auto errors = checkSoilWater(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return std::make_unique<SoilWater>(ObstacleScene(std::move(*read)), configuration);
}

}  // namespace espalier::environment
