// The process `gravity` (docs/environments.md): a constant force, by default down.
//
// O(n).

#include <array>

#include "environment/base/process_entry.h"
#include "environment/directions/direction_reply.h"
#include "environment/geometry/world_up.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kGravitySummary = "A constant force, by default down.";
constexpr std::array kGravityKeys{
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
            .summary = std::string(kGravitySummary),
            .needs = {.position = true},
            .inputs = {},
            .outputs = vectorOutputs("force", "1"),
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    if (core::length(direction_) > 0.0) {
      force_ = core::normalised(direction_) * strength_;
      return std::nullopt;
    }
    const auto up = upOf("gravity", context.world);
    if (!up) {
      return up.error();
    }
    force_ = -*up * strength_;
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

extern constinit const ProcessEntry kGravityProcess{.name = "gravity",
                                                    .summary = kGravitySummary,
                                                    .source = "Espalier's own",
                                                    .keys = kGravityKeys,
                                                    .make = [](const Configuration& configuration) -> ProcessOrErrors {
                                                      const auto direction = givenVector(configuration, "direction");
                                                      if (!direction) {
                                                        return refuseDirection("gravity", "direction");
                                                      }
                                                      return std::make_unique<Gravity>(configuration.number("strength"),
                                                                                       *direction);
                                                    }};

}  // namespace espalier::environment
