#include "environment/directions/gravity.h"

#include <array>

#include "environment/directions/direction_reply.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kSummary = "A constant force, down unless told otherwise.";
constexpr std::array kKeys{
    ConfigurationKey{.name = "strength", .description = "length of the vector", .defaultNumber = 1.0},
    ConfigurationKey{.name = "direction",
                     .kind = KeyKind::Numbers,
                     .description = "x, y, z of the direction, of any length but 0; empty: against the world's up",
                     .maximumCount = 3},
};

class Gravity final : public turtle::EnvironmentProcess {
 public:
  Gravity(double strength, const Vec3& direction) : strength_(strength), direction_(direction) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "gravity",
            .summary = std::string(kSummary),
            .needs = {.position = true},
            .inputs = {},
            .outputs = vectorOutputs("force", "1"),
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const bool isGiven = core::length(direction_) > 0.0;
    if (!isGiven && !(core::length(context.world.up) > 0.0)) {
      return turtle::EnvironmentError{
          "Environment 'gravity' needs to know where up is: the world's vector 'up' has no length. Set it to 0 1 0.",
          false};
    }
    force_ = core::normalised(isGiven ? direction_ : -context.world.up) * strength_;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    replyVectors(queries, replies, [this](const Vec3&) { return force_; });
    return std::nullopt;
  }

 private:
  double strength_;
  Vec3 direction_;  // as configured; no length: down
  Vec3 force_;
};

}  // namespace

constinit const ProcessEntry kGravityProcess{.name = "gravity",
                                             .summary = kSummary,
                                             .source = "Espalier's own",
                                             .aliases = {},
                                             .keys = kKeys,
                                             .fieldKeywords = {},
                                             .make = [](const Configuration& configuration) -> ProcessOrErrors {
                                               const auto direction = givenVector(configuration, "direction");
                                               if (!direction) {
                                                 return std::vector{wrongDirection("gravity", "direction")};
                                               }
                                               return std::make_unique<Gravity>(configuration.number("strength"),
                                                                                *direction);
                                             }};

}  // namespace espalier::environment
