// The process `ornament` as the published program: every query with two parameters stamps, also with the radius 0, and
// no more than 255 objects are counted in a cell. O(cells of the objects) + O(queries).

#include <cstdint>
#include <memory>
#include <string>

#include "engine/core/work_meter.h"
#include "environment/base/replies.h"
#include "environment/competition/published_variants.h"
#include "environment/competition/stamped_counts.h"
#include "environment/geometry/published_raster.h"

namespace espalier::environment {

namespace {

class PublishedOrnament final : public turtle::EnvironmentProcess {
 public:
  explicit PublishedOrnament(const Configuration& configuration)
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
      if (parameters.size() == 2) {
        core::pollWork();
        raster_.forEachRowOfDisc(queries.position[query], toFloat(parameters[1]),
                                 [this](std::size_t first, std::size_t last) { counts_.stamp(first, last); });
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (queries.parametersOf(query).size() == 2) {
        const auto cell = raster_.cellOf(queries.position[query]);
        replies.set(queries, query, 0, cell ? static_cast<double>(counts_.of(*cell)) : 0.0);
        replies.set(queries, query, 1, cell ? raster_.lightOf(*cell) : 0.0);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  PublishedRaster raster_;
  StampedCounts<std::uint8_t> counts_;
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedOrnament(const Configuration& configuration) {
  return std::make_unique<PublishedOrnament>(configuration);
}

}  // namespace espalier::environment
