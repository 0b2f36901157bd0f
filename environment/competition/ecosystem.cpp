// The process `ecosystem` (docs/environments.md): competition of plants for space by discs (spheres) of influence of
// their own radius.
//
// With `vigor` domination is settled from the strongest disc down, so it does not depend on the order of queries;
// `order` "published" settles it in string order. `compatible`: published_ecosystem.cpp. No state. O(n log n) for n
// discs.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/competition/disc_contest.h"
#include "environment/competition/published_variants.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kEcosystemSummary =
    "Competition for space by discs of influence: an overlapped weaker disc is dominated.";
constexpr std::array<std::string_view, 2> kEcosystemOrders{"independent", "published"};
constexpr std::array kEcosystemKeys{
    ConfigurationKey{.name = "vigor",
                     .kind = KeyKind::Boolean,
                     .description = "parameter 2 is a vigor that decides before the radius, instead of a group"},
    kThreeDimensionalKey,
    kPlaneKey,
    ConfigurationKey{.name = "order",
                     .kind = KeyKind::Choice,
                     .description = "with vigor: settle domination from the strongest down, or in string order",
                     .defaultText = "independent",
                     .choices = kEcosystemOrders},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "string order, and distances in 32-bit floats, as published"},
};
constexpr std::array kEcosystemPublishedKeywords{
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "vigor", .kind = PublishedKind::Switch, .key = "vigor", .onWords = kOn},
    PublishedKeyword{
        .keyword = "3d case", .kind = PublishedKind::Switch, .key = "threeDimensional", .onWords = kOnOrYes},
};

class Ecosystem final : public turtle::EnvironmentProcess {
 public:
  Ecosystem(const ContestRules& rules, Plane plane) : rules_(rules), plane_(plane) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return describeEcosystem(lengthUnit_, rules_.hasVigor);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Contender> contenders;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      contenders.push_back(contenderOf(queries, query, plane_));
    }
    answerContest(queries, dominatedOf(contenders, rules_, discsOverlap), replies);
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  ContestRules rules_;
  Plane plane_;
  std::string lengthUnit_ = "m";
};

}  // namespace

turtle::EnvironmentDescription describeEcosystem(const std::string& lengthUnit, bool hasVigor) {
  return {.name = "ecosystem",
          .summary = std::string(kEcosystemSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"radius", lengthUnit, ""}, {hasVigor ? "vigor" : "group", "1", ""}},
          .outputs = {{"isFree", "1", ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kEcosystemProcess{
    .name = "ecosystem",
    .summary = kEcosystemSummary,
    .source = "Deussen et al. 1998, Realistic modeling and rendering of plant ecosystems",
    .keys = kEcosystemKeys,
    .publishedKeywords = kEcosystemPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      const ContestRules rules{configuration.flag("vigor"), configuration.text("order") == "published"};
      if (configuration.flag("compatible")) {
        return makePublishedEcosystem(rules.hasVigor, planeOf(configuration));
      }
      return std::make_unique<Ecosystem>(rules, planeOf(configuration));
    }};

}  // namespace espalier::environment
