// The process `soil-water` (docs/environments.md): water in unsaturated ground with solutes and acidity, and roots that
// take them up.
//
// Richards' equation with van Genuchten's functions by layer (richards.h), any number of solutes and buffered H⁺
// (solutes.h), stones, rain and evaporation. All queries see the state of the step before; when they want more than a
// cell holds, each gets the same share of what it wants. Sums are sorted. The obtained amounts leave the cells evenly
// while the step's time passes. O(n log n + cells · time steps · iterations).

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/box_note.h"
#include "environment/soil/soil_body.h"

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
  explicit SoilWater(SoilBody body) : body_(std::move(body)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string& unit = body_.lengthUnit();
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
    days_ = context.world.stepDurationDays;
    return body_.open("soil-water", context.world);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    return orGoBack([&](const std::vector<double>& before) {
      answerState(queries, replies);
      takeUp(queries, replies);
      countAnswers(queries, replies);
      noteIfAllAreOutside("soil-water", body_.ground().box(), body_.lengthUnit(), queries, replies);
      return passTime(before);
    });
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    return orGoBack([this](const std::vector<double>& before) {
      std::fill(body_.water().sinks().begin(), body_.water().sinks().end(), 0.0);
      return passTime(before);
    });
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override { return body_.fields(); }

  [[nodiscard]] std::string save() const override { return saveNumbers(body_.numbers()); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    std::vector<double> read = body_.numbers();
    if (auto error = restoreNumbers(state, "soil-water", read)) {
      return error;
    }
    body_.setNumbers(read);
    return std::nullopt;
  }

 private:
  /// Advances; on an exception everything is as before.
  template <typename Advance>
  [[nodiscard]] std::optional<turtle::EnvironmentError> orGoBack(const Advance& advance) {
    const std::vector<double> before = body_.numbers();
    try {
      return advance(before);
    } catch (...) {
      body_.setNumbers(before);
      throw;
    }
  }

  void answerState(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) const {
    const auto contentOf = [&](std::size_t cell) { return body_.water().contentOf(cell); };
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = std::min(queries.parametersOf(query).size(), 7 + 2 * keys_.solutes.size());
      const auto cell = body_.cellOf(queries.position[query]);
      std::vector<double> values(7 + 2 * keys_.solutes.size(), 0.0);
      if (cell && count > 1) {
        const double content = body_.water().contentOf(*cell);
        const Vec3 gradient = body_.ground().gradientAt(*cell, body_.water(), contentOf);
        values[1] = body_.water().state().heads[*cell];
        values[2] = content;
        values[3] = gradient.x;
        values[4] = gradient.y;
        values[5] = gradient.z;
        values[6] = keys_.acidity ? body_.phOf(*cell) : 0.0;
        for (std::size_t solute = 0; solute < keys_.solutes.size(); ++solute) {
          values[8 + 2 * solute] = body_.solutes().concentration(solute, *cell, content);
        }
      }
      for (std::size_t k = 0; k < count; ++k) {
        // no number stands for the head or the pH of a place without soil: they stay as sent
        if (cell || (k != 1 && k != 6)) {
          replies.set(queries, query, k, values[k]);
        }
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
        if (const auto cell = body_.cellOf(queries.position[query])) {
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
    std::fill(body_.water().sinks().begin(), body_.water().sinks().end(), 0.0);
    constexpr double kNoLimit = 1e300;
    // solutes first: their concentrations are those of the water that was there
    for (std::size_t solute = 0; solute < keys_.solutes.size(); ++solute) {
      settle(
          queries, 7 + 2 * solute,
          [&](std::size_t cell) {
            return std::pair(std::max(body_.solutes().amounts(solute)[cell], 0.0) * body_.water().cellVolume(cell),
                             kNoLimit);
          },
          [&](std::size_t cell, double amount) {
            double& left = body_.solutes().amounts(solute)[cell];
            const double taken = amount / body_.water().cellVolume(cell);
            // rounding must not take more than there is
            left = taken > 0.0 && left >= 0.0 ? std::max(left - taken, 0.0) : left - taken;
          },
          replies);
    }
    if (keys_.acidity) {
      giveOffProtons(queries);
    }
    settle(
        queries, 0,
        [&](std::size_t cell) {
          const SoilLayer& soil = body_.water().soilOf(cell);
          const double content = body_.water().contentOf(cell);
          const double volume = body_.water().cellVolume(cell);
          return std::pair(std::max(content - soil.content(keys_.wiltingHead), 0.0) * volume,
                           std::max(soil.saturatedContent - content, 0.0) * volume);
        },
        [&](std::size_t cell, double amount) { body_.water().sinks()[cell] = amount / days_; }, replies);
  }

  void giveOffProtons(const turtle::QueryBatch& queries) {
    std::vector<std::pair<std::size_t, double>> given;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() > 6 && parameters[6] != 0.0) {
        if (const auto cell = body_.cellOf(queries.position[query])) {
          given.emplace_back(*cell, parameters[6]);
        }
      }
    }
    std::sort(given.begin(), given.end());
    for (const auto& [cell, amount] : given) {
      body_.solutes().amounts(keys_.solutes.size())[cell] += amount / body_.water().cellVolume(cell);
    }
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> passTime(const std::vector<double>& before) {
    auto error = body_.passTime(days_);
    if (error) {
      body_.setNumbers(before);
    }
    return error;
  }

  SoilBody body_;
  const SoilWaterKeys& keys_ = body_.keys();
  double days_ = 1.0;  // of a step
};

}  // namespace

ProcessOrErrors makeSoilWater(const Configuration& configuration) {
  auto body = makeSoilBody(configuration);
  if (!body) {
    return tl::unexpected(std::move(body.error()));
  }
  return std::make_unique<SoilWater>(std::move(*body));
}

}  // namespace espalier::environment
