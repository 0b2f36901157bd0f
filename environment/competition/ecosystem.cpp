// The process `ecosystem` (docs/environments.md): competition of plants for space by discs (spheres) of influence of
// their own radius.
//
// With `vigor` domination is settled from the strongest disc down, so it does not depend on the order of queries;
// `order` "published" settles it in string order. No state. O(n log n) for n discs.

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/disc_tree.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kSummary =
    "Competition for space by discs of influence: an overlapped weaker disc is dominated.";
constexpr std::array<std::string_view, 2> kOrders{"independent", "published"};
constexpr std::array<std::string_view, 1> kOn{"on"};
constexpr std::array<std::string_view, 2> kOnOrYes{"on", "yes"};
constexpr std::array kKeys{
    ConfigurationKey{.name = "vigor",
                     .kind = KeyKind::Boolean,
                     .description = "parameter 2 is a vigor that decides before the radius, instead of a group"},
    kThreeDimensionalKey,
    kPlaneKey,
    ConfigurationKey{.name = "order",
                     .kind = KeyKind::Choice,
                     .description = "with vigor: settle domination from the strongest down, or in string order",
                     .defaultText = "independent",
                     .choices = kOrders},
};
constexpr std::array kPublishedKeywords{
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "vigor", .kind = PublishedKind::Switch, .key = "vigor", .onWords = kOn},
    PublishedKeyword{
        .keyword = "3d case", .kind = PublishedKind::Switch, .key = "threeDimensional", .onWords = kOnOrYes},
};

class Ecosystem final : public turtle::EnvironmentProcess {
 public:
  Ecosystem(bool hasVigor, Plane plane, bool isPublishedOrder)
      : hasVigor_(hasVigor), plane_(plane), isPublishedOrder_(isPublishedOrder) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "ecosystem",
            .summary = std::string(kSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"radius", lengthUnit_, ""}, {hasVigor_ ? "vigor" : "group", "1", ""}},
            .outputs = {{"isFree", "1", ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<std::size_t> all(queries.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    if (hasVigor_) {
      settle(queries, all, replies);
    } else {
      // the groups do not compete with each other
      std::stable_sort(all.begin(), all.end(),
                       [&](std::size_t a, std::size_t b) { return secondOf(queries, a) < secondOf(queries, b); });
      for (auto begin = all.begin(); begin != all.end();) {
        const auto end = std::find_if(
            begin, all.end(), [&](std::size_t query) { return secondOf(queries, query) != secondOf(queries, *begin); });
        settle(queries, {begin, end}, replies);
        begin = end;
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  static double radiusOf(const turtle::QueryBatch& queries, std::size_t query) {
    const auto parameters = queries.parametersOf(query);
    return parameters.empty() ? 0.0 : parameters[0];
  }
  static double secondOf(const turtle::QueryBatch& queries, std::size_t query) {
    const auto parameters = queries.parametersOf(query);
    return parameters.size() < 2 ? 0.0 : parameters[1];
  }

  /// Vigor (when it counts), then radius.
  [[nodiscard]] std::pair<double, double> strengthOf(const turtle::QueryBatch& queries, std::size_t query) const {
    return {hasVigor_ ? secondOf(queries, query) : 0.0, radiusOf(queries, query)};
  }

  void settle(const turtle::QueryBatch& queries, const std::vector<std::size_t>& contest,
              turtle::ReplyBatch& replies) const {
    // ranks by strength; equal strengths share one
    std::vector<std::size_t> strongestFirst(contest.size());
    std::iota(strongestFirst.begin(), strongestFirst.end(), std::size_t{0});
    std::stable_sort(strongestFirst.begin(), strongestFirst.end(), [&](std::size_t a, std::size_t b) {
      return strengthOf(queries, contest[a]) > strengthOf(queries, contest[b]);
    });
    std::vector<Disc> discs(contest.size());
    auto rank = static_cast<std::uint32_t>(contest.size());
    for (std::size_t k = 0; k < contest.size(); ++k) {
      const std::size_t member = strongestFirst[k];
      if (k > 0 && strengthOf(queries, contest[member]) != strengthOf(queries, contest[strongestFirst[k - 1]])) {
        --rank;
      }
      discs[member] = {flattened(plane_, queries.position[contest[member]]), radiusOf(queries, contest[member]), rank};
    }

    // the dominated ones; with vigor they leave the contest
    DiscTree tree(discs);
    for (std::size_t k = 0; k < contest.size(); ++k) {
      // without vigor no disc is taken out, so the order does not matter
      const std::size_t member = !hasVigor_ ? tree.order()[k] : isPublishedOrder_ ? k : strongestFirst[k];
      const bool isDominated = tree.isOverlapped(member, discs[member].rank + (hasVigor_ ? 1U : 0U));
      if (isDominated && hasVigor_) {
        tree.remove(member);
      }
      if (!queries.parametersOf(contest[member]).empty()) {
        replies.set(queries, contest[member], 0, isDominated ? 0.0 : 1.0);
      }
    }
  }

  bool hasVigor_;
  Plane plane_;
  bool isPublishedOrder_;
  std::string lengthUnit_ = "m";
};

}  // namespace

extern constinit const ProcessEntry kEcosystemProcess{
    .name = "ecosystem",
    .summary = kSummary,
    .source = "Deussen et al. 1998, Realistic modeling and rendering of plant ecosystems",
    .keys = kKeys,
    .publishedKeywords = kPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Ecosystem>(configuration.flag("vigor"), planeOf(configuration),
                                         configuration.text("order") == "published");
    }};

}  // namespace espalier::environment
