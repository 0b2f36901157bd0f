// The process `clover` as the published program: cells and leaves of PublishedRaster, and counts that stay within
// 0 … 255. O(cells of the leaves) + O(queries).

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "environment/base/replies.h"
#include "environment/geometry/published_raster.h"
#include "environment/light/leaf_counts.h"
#include "environment/light/published_variants.h"

namespace espalier::environment {

namespace {

constexpr double kLeastTransmittance = 0.0001;  // that of a leaf that lets nothing pass
constexpr float kLeastArea = 1e-7F;             // of a leaf that covers any cell

class PublishedClover final : public turtle::EnvironmentProcess {
 public:
  explicit PublishedClover(const Configuration& configuration)
      : raster_(configuration),
        transmittance_(configuration.number("transmittance")),
        forgets_(configuration.flag("removeOldLeaves")),
        leaves_(raster_.cellCount(), 0) {
    transmittance_ = transmittance_ == 0.0 ? kLeastTransmittance : transmittance_;
  }

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
      stamp(queries.position[query], toFloat(parameters[1]), parameters[0] == 1.0 ? 1 : -1);
    });
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() == 1 || (parameters.size() > 1 && parameters[0] == 0.0)) {
        answer(queries, query, replies);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override { return saveLeafCounts(leaves_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return restoreLeafCounts(state, leaves_);
  }

 private:
  void stamp(const core::Vec3& centre, float area, std::int32_t change) {
    if (!(area >= kLeastArea)) {
      return;
    }
    const auto radius = static_cast<float>(std::sqrt(static_cast<double>(area) / std::numbers::pi));
    raster_.forEachCellOfDisc(centre, radius,
                              [&](std::size_t cell) { leaves_[cell] = std::clamp(leaves_[cell] + change, 0, 255); });
  }

  void answer(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) const {
    const auto cell = raster_.cellOf(queries.position[query]);
    replies.set(queries, query, 0,
                cell ? raster_.lightOf(*cell) / 255.0 * std::pow(transmittance_, leaves_[*cell]) : 0.0);
    if (queries.parametersOf(query).size() > 1) {
      replies.set(queries, query, 1, cell ? raster_.secondOf(*cell) / 128.0 : 0.0);
    }
  }

  PublishedRaster raster_;
  double transmittance_;
  bool forgets_;
  std::vector<std::int32_t> leaves_;  // leaves over a cell, 0 … 255 (cellCount)
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedClover(const Configuration& configuration) {
  return std::make_unique<PublishedClover>(configuration);
}

}  // namespace espalier::environment
