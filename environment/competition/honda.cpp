// The process `honda` (docs/environments.md): collisions of branch tips with clusters of leaves of one radius.
//
// No state, independent of the order of queries. `compatible`: published_honda.cpp. O(n log n) for n queries, for any
// crowding.

#include <array>
#include <memory>
#include <vector>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/competition/published_variants.h"
#include "environment/competition/tip_collisions.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kHondaSummary =
    "Collision of tips of equal radius: a tip may grow unless another of its group with at least its vigor is near.";
constexpr std::array<std::string_view, 1> kHondaAliases{"honda81"};
constexpr std::array kHondaKeys{
    ConfigurationKey{.name = "radius",
                     .description = "distance up to which tips collide",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 0.0},
    kThreeDimensionalKey,
    kPlaneKey,
    ConfigurationKey{
        .name = "compatible", .kind = KeyKind::Boolean, .description = "distances in 32-bit floats, as published"},
};
constexpr std::array kHondaPublishedKeywords{
    PublishedKeyword{.keyword = "radius", .kind = PublishedKind::Number, .key = "radius"},
    PublishedKeyword{.keyword = "3d case", .kind = PublishedKind::Switch, .key = "threeDimensional", .onWords = kOn},
};

class Honda final : public turtle::EnvironmentProcess {
 public:
  Honda(double radius, Plane plane) : radius_(radius), plane_(plane) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeHonda(); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Tip> tips;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      tips.push_back(tipOf(queries, query, plane_));
    }
    const auto isNear = [&](const Tip& a, const Tip& b) {
      const core::Vec3 offset = b.position - a.position;
      return core::dot(offset, offset) <= radius_ * radius_;
    };
    TipCollisions(tips, radius_, plane_).settle(isNear, [&](std::size_t tip, bool isBlocked) {
      if (!queries.parametersOf(tip).empty()) {
        replies.set(queries, tip, 0, isBlocked ? 0.0 : 1.0);
      }
    });
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  double radius_;
  Plane plane_;
};

}  // namespace

turtle::EnvironmentDescription describeHonda() {
  return {.name = "honda",
          .summary = std::string(kHondaSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"vigor", "1", ""}, {"group", "1", ""}},
          .outputs = {{"mayGrow", "1", ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kHondaProcess{
    .name = "honda",
    .summary = kHondaSummary,
    .source =
        "Honda, Tomlinson & Fisher 1981, Computer simulation of branch interaction and regulation by unequal flow "
        "rates in botanical trees; Mech & Prusinkiewicz 1996",
    .aliases = kHondaAliases,
    .keys = kHondaKeys,
    .publishedKeywords = kHondaPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      const double radius = configuration.number("radius");
      const Plane plane = planeOf(configuration);
      if (configuration.flag("compatible")) {
        return makePublishedHonda(radius, plane);
      }
      return std::make_unique<Honda>(radius, plane);
    }};

}  // namespace espalier::environment
