// The process `ornament` (docs/environments.md): objects stamped on a raster that is empty again in every step.
//
// All objects of a step are stamped before any is counted. `compatible`: published_ornament.cpp. O(cells of the
// objects)
// + O(queries).

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/competition/published_variants.h"
#include "environment/competition/stamped_counts.h"
#include "environment/geometry/box_note.h"
#include "environment/geometry/raster.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kOrnamentSummary = "Counts objects stamped on a raster, which is empty again in every step.";
constexpr std::array kOrnamentOwnKeys{
    ConfigurationKey{
        .name = "compatible", .kind = KeyKind::Boolean, .description = "cells, discs and pixels as published"},
};
constexpr auto kOrnamentKeys = joinTables(kRasterKeys, kOrnamentOwnKeys);

class Ornament final : public turtle::EnvironmentProcess {
 public:
  explicit Ornament(const Configuration& configuration)
      : raster_(configuration), counts_(raster_.cellCount(), raster_.cellsInRow()) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeOrnament(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    counts_.clear();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() > 1 && parameters[1] > 0.0) {
        core::pollWork();
        raster_.forEachRowOfDisc(queries.position[query], parameters[1],
                                 [this](std::size_t first, std::size_t last) { counts_.stamp(first, last); });
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() < 2) {
        continue;
      }
      const auto cell = raster_.cellOf(queries.position[query]);
      replies.set(queries, query, 0, cell ? static_cast<double>(counts_.of(*cell)) : 0.0);
      replies.set(queries, query, 1, cell ? raster_.lightOf(*cell) : 0.0);
    }
    countAnswers(queries, replies);
    noteIfAllAreOutside("ornament", raster_.shape().box(), lengthUnit_, queries, replies);
    return std::nullopt;
  }

 private:
  Raster raster_;
  StampedCounts<std::uint32_t> counts_;
  std::string lengthUnit_ = "m";
};

}  // namespace

turtle::EnvironmentDescription describeOrnament(const std::string& lengthUnit) {
  return {.name = "ornament",
          .summary = std::string(kOrnamentSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"unused", "1", ""}, {"radius", lengthUnit, ""}},
          .outputs = {{"objects", "1", ""}, {"light", "1", ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kOrnamentProcess{.name = "ornament",
                                                     .summary = kOrnamentSummary,
                                                     .source = "the published program ornament",
                                                     .keys = kOrnamentKeys,
                                                     .publishedKeywords = kRasterKeywords,
                                                     .make = [](const Configuration& configuration) -> ProcessOrErrors {
                                                       if (auto problems = problemsOfRaster("ornament", configuration);
                                                           !problems.empty()) {
                                                         return tl::unexpected(std::move(problems));
                                                       }
                                                       if (configuration.flag("compatible")) {
                                                         return makePublishedOrnament(configuration);
                                                       }
                                                       return std::make_unique<Ornament>(configuration);
                                                     }};

}  // namespace espalier::environment
