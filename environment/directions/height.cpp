// The process `height` (docs/environments.md): the height of a point along the world's up, the teaching example of open
// L-systems.
//
// No state. O(n).

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/world_up.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kHeightSummary = "Returns the height of the queried point above the origin.";

class Height final : public turtle::EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "height",
            .summary = std::string(kHeightSummary),
            .needs = {.position = true},
            .inputs = {},
            .outputs = {{"height", lengthUnit_, ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("height", context.world);
    if (!up) {
      return up.error();
    }
    up_ = *up;
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (!queries.parametersOf(query).empty()) {
        replies.set(queries, query, 0, core::dot(queries.position[query], up_));
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  core::Vec3 up_{0.0, 1.0, 0.0};
  std::string lengthUnit_ = "m";
};

}  // namespace

extern constinit const ProcessEntry kHeightProcess{
    .name = "height",
    .summary = kHeightSummary,
    .source = "the teaching example of open L-systems",
    .make = [](const Configuration&) -> ProcessOrErrors { return std::make_unique<Height>(); }};

}  // namespace espalier::environment
