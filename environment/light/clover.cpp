// The process `clover` (docs/environments.md): light on the ground under the leaves of creeping plants.
//
// All adds and removes of a step come before its answers, so the order of queries does not matter. The counts of leaves
// are the state. `compatible`: published_clover.cpp. O(cells of the leaves) + O(queries).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "engine/core/elementary.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/box_note.h"
#include "environment/geometry/raster.h"
#include "environment/light/leaf_counts.h"
#include "environment/light/published_variants.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kCloverSummary = "Light from above on a raster that leaf discs shade.";
constexpr std::array kCloverOwnKeys{
    ConfigurationKey{.name = "transmittance",
                     .description = "part of the light that passes a leaf",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.6},
    ConfigurationKey{.name = "removeOldLeaves",
                     .kind = KeyKind::Boolean,
                     .description = "remove all leaves at the beginning of every step with queries"},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "cells, leaves, pixels and counts within 0 and 255 as published"},
};
constexpr auto kCloverKeys = joinTables(kRasterKeys, kCloverOwnKeys);
constexpr std::array kOwnKeywords{
    PublishedKeyword{.keyword = "transmittance", .key = "transmittance"},
    PublishedKeyword{
        .keyword = "remove old leaves", .kind = PublishedKind::Switch, .key = "removeOldLeaves", .onWords = kOnOrYes},
};
constexpr auto kCloverPublishedKeywords = joinTables(kRasterKeywords, kOwnKeywords);

class Clover final : public turtle::EnvironmentProcess {
 public:
  explicit Clover(const Configuration& configuration)
      : raster_(configuration),
        transmittance_(configuration.number("transmittance")),
        forgets_(configuration.flag("removeOldLeaves")),
        leaves_(raster_.cellCount(), 0) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeClover(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    std::fill(leaves_.begin(), leaves_.end(), 0);
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    // all leaves first, then all answers
    std::vector<std::size_t> leaves;
    double cellCount = 0.0;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (queries.parametersOf(query).size() > 1 && queries.parametersOf(query)[0] != 0.0) {
        leaves.push_back(query);
        cellCount += raster_.shape().cellsOfArea(std::max(queries.parametersOf(query)[1], 0.0));
      }
    }
    stampAll(leaves, cellCount, forgets_ && queries.size() > 0, leaves_, [&](std::size_t query) {
      const auto parameters = queries.parametersOf(query);
      stamp(queries.position[query], parameters[1], parameters[0] == 1.0 ? 1 : -1);
    });
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() == 1 || (parameters.size() > 1 && parameters[0] == 0.0)) {
        answer(queries, query, replies);
      }
    }
    countAnswers(queries, replies);
    noteIfAllAreOutside("clover", raster_.shape().box(), lengthUnit_, queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override { return saveLeafCounts(leaves_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return restoreLeafCounts(state, leaves_);
  }

 private:
  void stamp(const core::Vec3& centre, double area, std::int32_t change) {
    if (!(area > 0.0)) {
      return;
    }
    raster_.forEachCellOfDisc(centre, std::sqrt(area / std::numbers::pi),
                              [&](std::size_t cell) { leaves_[cell] += change; });
  }

  void answer(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) const {
    const auto cell = raster_.cellOf(queries.position[query]);
    double light = 0.0;
    double second = 0.0;
    if (cell) {
      light = raster_.lightOf(*cell) / 255.0 * core::pow(transmittance_, std::max(leaves_[*cell], 0));
      second = raster_.secondOf(*cell) / 128.0;
    }
    replies.set(queries, query, 0, light);
    if (queries.parametersOf(query).size() > 1) {
      replies.set(queries, query, 1, second);
    }
  }

  Raster raster_;
  double transmittance_;
  bool forgets_;
  std::vector<std::int32_t> leaves_;  // leaves over a cell (cellCount)
  std::string lengthUnit_ = "m";
};

}  // namespace

turtle::EnvironmentDescription describeClover(const std::string& lengthUnit) {
  return {.name = "clover",
          .summary = std::string(kCloverSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"action", "1", ""}, {"leafArea", lengthUnit + "^2", ""}},
          .outputs = {{"light", "1", ""}, {"second", "1", ""}},
          .isStateful = true};
}

extern constinit const ProcessEntry kCloverProcess{
    .name = "clover",
    .summary = kCloverSummary,
    .source = "the published program clover; Bell 1986, The simulation of branching patterns in modular organisms",
    .keys = kCloverKeys,
    .publishedKeywords = kCloverPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      if (auto problems = problemsOfRaster("clover", configuration); !problems.empty()) {
        return tl::unexpected(std::move(problems));
      }
      if (configuration.flag("compatible")) {
        return makePublishedClover(configuration);
      }
      return std::make_unique<Clover>(configuration);
    }};

}  // namespace espalier::environment
