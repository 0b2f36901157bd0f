// The process `meadow` (docs/environments.md): insects that feel the density of plants around them and each other.
//
// `compatible`: only queries before a module I with three parameters are insects, and cells are those of the published
// raster. Without a neighbour p5 and p6 then stay as sent, where the published program leaves garbage. O(n log n) for
// any crowding.

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <optional>
#include <vector>

#include "engine/core/elementary.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/point_tree.h"
#include "environment/geometry/published_raster.h"
#include "environment/geometry/raster.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kMeadowSummary = "Insects that feel the density of plants around them and each other.";
constexpr std::array kMeadowOwnKeys{
    ConfigurationKey{.name = "radius",
                     .description = "distance up to which an insect feels",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "only queries before a module I with three parameters are insects"},
};
constexpr auto kMeadowKeys = joinTables(kRasterKeys, kMeadowOwnKeys);
constexpr std::array<std::string_view, 1> kMeadowAliases{"Meadow"};

/// Raster or PublishedRaster: where a point lies on the maps.
template <typename AnyRaster>
class Meadow final : public turtle::EnvironmentProcess {
 public:
  explicit Meadow(const Configuration& configuration)
      : raster_(configuration),
        plane_(planeNamed(configuration.text("plane"))),
        radius_(configuration.number("radius")),
        isCompatible_(configuration.flag("compatible")),
        added_(raster_.cellCount(), 0.0) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "meadow",
            .summary = std::string(kMeadowSummary),
            .needs = {.position = true, .parameters = true, .following = isCompatible_},
            .inputs = {{"addedDensity", "1", ""}},
            .outputs = {{"density", "1", ""},
                        {"gradientAcross", "1", ""},
                        {"gradientAlong", "1", ""},
                        {"nearestInsect", "1", ""},
                        {"wayAcross", lengthUnit_, ""},
                        {"wayAlong", lengthUnit_, ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    symbols_ = context.symbols;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    addDensities(queries);
    std::vector<std::size_t> insects;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (isInsect(queries, query)) {
        insects.push_back(query);
      }
    }
    // numbered by plant and module, whatever the order of the queries
    std::stable_sort(insects.begin(), insects.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(queries.plant[a], queries.module[a]) < std::pair(queries.plant[b], queries.module[b]);
    });
    std::vector<Vec3> places;
    for (const std::size_t query : insects) {
      places.push_back(flattened(plane_, queries.position[query]));
    }
    const PointTree tree(places);
    for (const std::uint32_t insect : tree.order()) {
      answer(queries, insects[insect], insect, tree.nearestOther(insect, radius_ * radius_), places, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  [[nodiscard]] bool isInsect(const turtle::QueryBatch& queries, std::size_t query) const {
    if (queries.parametersOf(query).size() != 6) {
      return false;
    }
    if (!isCompatible_) {
      return true;
    }
    const core::SymbolId symbol = queries.following.empty() ? core::kNoSymbol : queries.following[query];
    return symbol < symbols_.size() && symbols_[symbol] == "I" && queries.followingParametersOf(query).size() == 3;
  }

  void addDensities(const turtle::QueryBatch& queries) {
    for (const std::size_t cell : touched_) {
      added_[cell] = 0.0;
    }
    touched_.clear();
    std::vector<std::pair<std::size_t, double>> given;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      const auto cell = parameters.size() == 1 ? raster_.cellOf(queries.position[query]) : std::nullopt;
      if (cell) {
        given.emplace_back(*cell, parameters[0]);
      }
    }
    // sorted, sums do not depend on the order of queries
    std::sort(given.begin(), given.end());
    for (const auto& [cell, density] : given) {
      added_[cell] += density;
      touched_.push_back(cell);
    }
  }

  [[nodiscard]] double densityAt(const Vec3& place) const {
    const auto cell = raster_.cellOf(place);
    return cell ? raster_.lightOf(*cell) / 255.0 + added_[*cell] : 0.0;
  }

  [[nodiscard]] Vec3 offset(double across, double along) const {
    switch (plane_) {
      case Plane::Yz:
        return {0.0, across, along};
      case Plane::Xz:
        return {across, 0.0, along};
      case Plane::Xy:
      case Plane::Space:
        break;
    }
    return {across, along, 0.0};
  }

  void answer(const turtle::QueryBatch& queries, std::size_t query, std::uint32_t insect,
              std::optional<std::uint32_t> nearest, const std::vector<Vec3>& places,
              turtle::ReplyBatch& replies) const {
    // sums of rows and columns, added up in the same order so that a flat density has no gradient
    std::array<double, 3> rows{};
    std::array<double, 3> columns{};
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double density = densityAt(queries.position[query] + offset((static_cast<double>(i) - 1.0) * radius_,
                                                                          (static_cast<double>(j) - 1.0) * radius_));
        rows[j] += density;
        columns[i] += density;
      }
    }
    const double sum = rows[0] + rows[1] + rows[2];
    const double across = columns[2] - columns[0];
    const double along = rows[2] - rows[0];
    const double length = core::hypot(across, along);
    replies.set(queries, query, 0, sum / 9.0);
    replies.set(queries, query, 1, length > 0.0 ? across / length : 0.0);
    replies.set(queries, query, 2, length > 0.0 ? along / length : 0.0);
    replies.set(queries, query, 3, nearest ? static_cast<double>(*nearest) : -1.0);
    if (!nearest && isCompatible_) {
      return;
    }
    const Vec3 way = places[nearest.value_or(insect)] - places[insect];
    replies.set(queries, query, 4, plane_ == Plane::Yz ? way.y : way.x);
    replies.set(queries, query, 5, plane_ == Plane::Xy ? way.y : way.z);
  }

  AnyRaster raster_;
  Plane plane_;
  double radius_;
  bool isCompatible_;
  std::vector<double> added_;         // density of plants that ask, by cell
  std::vector<std::size_t> touched_;  // cells that are not 0
  std::vector<std::string> symbols_;  // names by SymbolId
  std::string lengthUnit_ = "m";
};

}  // namespace

extern constinit const ProcessEntry kMeadowProcess{.name = "meadow",
                                                   .summary = kMeadowSummary,
                                                   .source = "the published program Meadow",
                                                   .aliases = kMeadowAliases,
                                                   .keys = kMeadowKeys,
                                                   .publishedKeywords = kRasterKeywords,
                                                   .make = [](const Configuration& configuration) -> ProcessOrErrors {
                                                     if (auto problems = problemsOfRaster("meadow", configuration);
                                                         !problems.empty()) {
                                                       return tl::unexpected(std::move(problems));
                                                     }
                                                     if (configuration.flag("compatible")) {
                                                       return std::make_unique<Meadow<PublishedRaster>>(configuration);
                                                     }
                                                     return std::make_unique<Meadow<Raster>>(configuration);
                                                   }};

}  // namespace espalier::environment
