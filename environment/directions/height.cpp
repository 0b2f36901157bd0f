#include "environment/directions/height.h"

#include "environment/base/replies.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kSummary = "Returns the height of the queried point above the origin.";

class Height final : public turtle::EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "height",
            .summary = std::string(kSummary),
            .needs = {.position = true},
            .inputs = {},
            .outputs = {{"height", lengthUnit_, ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    if (!(core::length(context.world.up) > 0.0)) {
      return turtle::EnvironmentError{
          "Environment 'height' needs to know where up is: the world's vector 'up' has no length. Set it to 0 1 0.",
          false};
    }
    up_ = core::normalised(context.world.up);
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

constinit const ProcessEntry kHeightProcess{
    .name = "height",
    .summary = kSummary,
    .source = "the teaching example of open L-systems",
    .aliases = {},
    .keys = {},
    .fieldKeywords = {},
    .make = [](const Configuration&) -> ProcessOrErrors { return std::make_unique<Height>(); }};

}  // namespace espalier::environment
