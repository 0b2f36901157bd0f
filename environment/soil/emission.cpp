// The process `emission` (docs/environments.md): plants give off a substance into a field that diffuses and decays, and
// feel its concentration.
//
// dc/dt = D∇²c − λc over World::stepDurationDays, in as many explicit steps of face fluxes as stability needs. Sums are
// sorted, so the order of queries does not matter. Matter is conserved except for the decay and the flow out of an open
// box. O(n log n + cells · diffusion steps).

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "environment/base/number_text.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/box_note.h"
#include "environment/geometry/grid_keys.h"
#include "environment/soil/soil_field.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kEmissionSummary =
    "A substance that plants give off, that spreads and decays, and that they feel.";
constexpr std::array kEmissionGridSize{32.0, 32.0, 32.0};
constexpr std::array<std::string_view, 2> kBorders{"closed", "open"};
constexpr double kMostSteps = 100000;
constexpr double kMostEmissionWork = 1e11;  // changes of cells in a step of the simulation: about a minute
constexpr std::size_t kEmissionMaximumCellCount = std::size_t{1} << 26;
constexpr std::array kEmissionKeys{
    gridSizeKey(kEmissionGridSize, "cells along x, y, z; one along z: a plane field"),
    ConfigurationKey{.name = "cellSize",
                     .description = "side of a cell, which is a cube",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.0},
    positionKey(kOrigin),
    ConfigurationKey{.name = "diffusivity",
                     .description = "diffusivity D",
                     .unit = "length^2/day",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "decayRate", .description = "decay rate λ", .unit = "1/day", .minimum = 0.0},
    ConfigurationKey{.name = "initialConcentration",
                     .description = "initial concentration of all cells",
                     .unit = "1/length^3",
                     .minimum = 0.0},
    ConfigurationKey{.name = "border",
                     .kind = KeyKind::Choice,
                     .description = "whether the substance leaves through the sides of the box, outside of which there "
                                    "is none",
                     .defaultText = "closed",
                     .choices = kBorders},
};

class Emission final : public turtle::EnvironmentProcess {
 public:
  Emission(SoilField field, const Configuration& configuration)
      : field_(std::move(field)),
        cellSize_(configuration.number("cellSize")),
        diffusivity_(configuration.number("diffusivity")),
        decayRate_(configuration.number("decayRate")) {
    diffusion_.isOpen = configuration.text("border") == "open";
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string volume = lengthUnit_ + "^3";
    const std::string steepness = "1/" + lengthUnit_ + "^4";
    return {.name = "emission",
            .summary = std::string(kEmissionSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"amount", "1", ""}},
            .outputs = {{"concentration", "1/" + volume, ""},
                        {"gradientX", steepness, ""},
                        {"gradientY", steepness, ""},
                        {"gradientZ", steepness, ""}},
            .isStateful = true};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const double days = context.world.stepDurationDays;
    if (!(days > 0.0)) {
      return turtle::EnvironmentError{
          "Environment 'emission' lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.",
          false};
    }
    // the part of a cell's content that moves in all, spread over steps that each move at most 0.9 of it
    const double faces = field_.isInSpace() ? 6.0 : 4.0;
    const double moved = faces * diffusivity_ * days / (cellSize_ * cellSize_);
    const double steps = std::ceil(moved / 0.9);
    if (!(steps <= kMostSteps)) {
      return turtle::EnvironmentError{
          "Environment 'emission' would need more than 100000 diffusion steps in a step of " + std::to_string(days) +
              " days. Use larger cells, a smaller diffusivity or shorter steps.",
          false};
    }
    if (const auto cells = static_cast<double>(field_.cells().size()); !(steps * cells <= kMostEmissionWork)) {
      return turtle::EnvironmentError{"Environment 'emission' would take minutes for a step: " + numberText(steps) +
                                          " diffusion steps of " + std::to_string(field_.cells().size()) +
                                          " cells. Use larger or fewer cells, a smaller diffusivity or shorter steps.",
                                      false};
    }
    diffusion_.stepCount = static_cast<int>(steps);
    diffusion_.relaxation = steps > 0.0 ? moved / steps : 0.0;
    diffusion_.staying = core::exp(-decayRate_ * days);
    lengthUnit_ = context.world.lengthUnit;
    field_.reset();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    field_.prepareToSpread(diffusion_);
    std::vector<std::pair<std::size_t, double>> given;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.empty()) {
        continue;
      }
      const auto cell = field_.cellOf(queries.position[query]);
      const Vec3 slope = cell ? field_.differencesAt(*cell) * (1.0 / cellSize_) : Vec3{};
      const std::array<double, 4> answer{cell ? field_.cells()[*cell] : 0.0, slope.x, slope.y, slope.z};
      for (std::size_t k = 0; k < std::min<std::size_t>(parameters.size(), 4); ++k) {
        replies.set(queries, query, k, answer[k]);
      }
      if (cell) {
        given.emplace_back(*cell, parameters[0]);
      }
    }
    countAnswers(queries, replies);
    noteIfAllAreOutside("emission", field_.box(), lengthUnit_, queries, replies);
    field_.orGoBack(diffusion_.stepCount, [&] {
      giveOff(std::move(given));
      field_.spread(diffusion_);
    });
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    field_.orGoBack(diffusion_.stepCount, [&] { field_.spread(diffusion_); });
    return std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    return {field_.field("concentration", "1/" + lengthUnit_ + "^3")};
  }
  [[nodiscard]] std::string save() const override { return saveNumbers(field_.cells()); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return restoreNumbers(state, "emission", field_.cells());
  }

 private:
  /// Adds what plants give off, amounts by cell.
  void giveOff(std::vector<std::pair<std::size_t, double>> given) {
    // sorted, the sums of a cell are the same for any order of queries
    std::sort(given.begin(), given.end());
    const double volume = cellSize_ * cellSize_ * cellSize_;
    for (std::size_t begin = 0; begin < given.size();) {
      double amount = 0.0;
      std::size_t end = begin;
      for (; end < given.size() && given[end].first == given[begin].first; ++end) {
        amount += given[end].second;
      }
      field_.cells()[given[begin].first] += amount / volume;
      begin = end;
    }
  }

  SoilField field_;
  double cellSize_;
  double diffusivity_;
  double decayRate_;
  Diffusion diffusion_;
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeEmission(const Configuration& configuration) {
  const SoilField::Shape shape{vectorOf(configuration, "position"),
                               vectorOf(configuration, "gridSize") * configuration.number("cellSize"),
                               cellsOf(configuration)};
  if (auto problem = tooManyCells("emission", shape.cells, kEmissionMaximumCellCount)) {
    return tl::unexpected(std::vector{std::move(*problem)});
  }
  const std::size_t cellCount = shape.cells[0] * shape.cells[1] * shape.cells[2];
  std::vector<double> initial(cellCount, configuration.number("initialConcentration"));
  return std::make_unique<Emission>(SoilField(shape, std::move(initial), {}, {}), configuration);
}

}  // namespace

extern constinit const ProcessEntry kEmissionProcess{.name = "emission",
                                                     .summary = kEmissionSummary,
                                                     .source = "Fick's law in finite volumes",
                                                     .keys = kEmissionKeys,
                                                     .make = makeEmission};

}  // namespace espalier::environment
