// The process `takenaka` (docs/environments.md): photosynthesis of balls of leaves that shade each other.
//
// `compatible`: published_takenaka.cpp. O(n · sources · (log n + balls met)).

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "environment/base/length_unit.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_keys.h"
#include "environment/geometry/sphere_tree.h"
#include "environment/geometry/world_up.h"
#include "environment/light/light_directions.h"
#include "environment/light/light_sources.h"
#include "environment/light/published_variants.h"
#include "environment/light/published_voxels.h"
#include "environment/light/ray_sums.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kTakenakaSummary = "Photosynthesis of balls of leaves that shade each other.";
constexpr double kTakenakaDarkness = 1e-12;
constexpr std::int64_t kManyBalls = 100'000;
constexpr double kYearlyLight = 1000e-6 * 12 * 3600 * 200;  // mol m^-2 a year

constexpr std::array kTakenakaKeys{
    ConfigurationKey{.name = "parameterS",
                     .description = "s: the ball's radius relative to that of its leaves laid out as a sphere",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.5},
    ConfigurationKey{.name = "transmittance",
                     .description = "part of the light that passes a leaf",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.1},
    ConfigurationKey{.name = "efficiency",
                     .description = "product made of a unit of light",
                     .unit = "1/mol",
                     .minimum = 0.0,
                     .defaultNumber = 0.015},
    ConfigurationKey{.name = "sources",
                     .kind = KeyKind::Rows,
                     .description = "light sources: position x, y, z and a weight; empty: straight above, far away",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{
        .name = "diskSource",
        .kind = KeyKind::Numbers,
        .description = "instead of sources parallel light from above: radius and middle of a disc, x, y, z",
        .unit = "length"},
    ConfigurationKey{.name = "beamRadius",
                     .description = "radius of a beam relative to the ball's that it reaches; it widens the others",
                     .minimum = 0.0},
    gridSizeKey(kUnitSides, "voxels along x, y, z of the published traversal (only when compatible)"),
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "as the published program, which misses balls and has ten times the light"},
};
constexpr std::array kTakenakaPublishedKeywords{
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Numbers, .key = "gridSize", .count = 3},
    PublishedKeyword{.keyword = "parameter s", .key = "parameterS"},
    PublishedKeyword{.keyword = "transmittance", .key = "transmittance"},
    PublishedKeyword{.keyword = "efficiency", .key = "efficiency"},
    PublishedKeyword{.keyword = "source", .kind = PublishedKind::Row, .key = "sources", .count = 4},
    PublishedKeyword{.keyword = "disk source", .kind = PublishedKind::Numbers, .key = "diskSource", .count = 4},
    PublishedKeyword{.keyword = "beam radius", .key = "beamRadius"},
};

class Takenaka final : public turtle::EnvironmentProcess {
 public:
  explicit Takenaka(const Configuration& configuration)
      : s_(configuration.number("parameterS")),
        efficiency_(configuration.number("efficiency")),
        beamRadius_(configuration.number("beamRadius")) {
    const double gap = 1.0 - (1.0 - configuration.number("transmittance")) / (s_ * s_);
    passing_ = gap * gap;
    // the most balls behind which it is not dark; as many as one likes where that is many
    double left = 1.0;
    while (left > kTakenakaDarkness && limit_ < kManyBalls) {
      left *= passing_;
      limit_ += left > kTakenakaDarkness ? 1 : 0;
    }
    limit_ = limit_ == kManyBalls ? RaySums::kMostLimit : limit_;
    for (const auto& row : configuration.rows("sources")) {
      // the place of a source, not yet a direction
      sources_.push_back({{row[0], row[1], row[2]}, row[3]});
      weight_ += row[3];
    }
    if (const std::vector<double>& disk = configuration.numbers("diskSource"); !disk.empty()) {
      disk_ = Sphere{{disk[1], disk[2], disk[3]}, disk[0]};
      sources_.clear();
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeTakenaka(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("takenaka", context.world);
    if (!up) {
      return up.error();
    }
    const LengthUnit* unit = findLengthUnit(context.world.lengthUnit);
    if (unit == nullptr) {
      return unknownLengthUnit("takenaka", context.world);
    }
    lengthUnit_ = context.world.lengthUnit;
    hits_.clear();
    light_ = kYearlyLight * unit->metres * unit->metres;
    up_ = *up;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Sphere> balls;
    std::vector<std::size_t> queryOf;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() == 2) {
        const double area = std::max(parameters[0], 0.0);
        balls.push_back({queries.position[query], s_ * 0.5 * std::sqrt(area / std::numbers::pi)});
        queryOf.push_back(query);
      }
    }
    const DistinctSpheres distinct = distinctSpheres(balls);
    const std::vector<double> light = lightOf(distinct);
    for (std::size_t ball = 0; ball < balls.size(); ++ball) {
      setAnswer(queries, queryOf[ball], light[distinct.indexOf[ball]], replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  /// Whether a ray from one ball meets another, ahead of its origin and before its end.
  [[nodiscard]] bool isMet(const Ray& ray, const Sphere& own, const Sphere& other) const {
    const Vec3 between = other.centre - ray.origin;
    const double ahead = core::dot(between, ray.direction);
    const double radius = other.radius + beamRadius_ * own.radius;
    const double squared = core::dot(between, between) - ahead * ahead;
    if (squared > radius * radius) {
      return false;
    }
    const double half = std::sqrt(std::max(radius * radius - squared, 0.0));
    return ahead + half > 0.0 && ahead - half < ray.reach;
  }

  /// The light of every ball, by the numbers of balls on its rays, which are kept from step to step.
  [[nodiscard]] std::vector<double> lightOf(const DistinctSpheres& distinct) {
    std::vector<double> light(distinct.spheres.size());
    hits_.update(distinct,
                 RaySums::Rays{std::max<std::size_t>(sources_.size(), 1), limit_,
                               [&](const Sphere& own, std::size_t k) { return rayOf(own, k); },
                               [&](const Sphere& own) { return beamRadius_ * own.radius; },
                               [&](const Sphere& own, const Sphere& other, const Ray& ray) {
                                 return static_cast<std::int64_t>(isMet(ray, own, other));
                               },
                               sources_.empty()},
                 [&](std::uint32_t index, std::span<const std::int64_t> hits) {
                   light[index] = arrivingLight(distinct.spheres[index], [&](const Ray&, std::size_t source) {
                     return lightAfter(hits[source]);
                   });
                 });
    return light;
  }

  /// The part of the light that passes so many balls.
  [[nodiscard]] double lightAfter(std::int64_t hits) const {
    if (hits == RaySums::kBeyond) {
      return 0.0;
    }
    double left = 1.0;
    for (std::int64_t k = 0; k < hits; ++k) {
      left *= passing_;
    }
    return left;
  }

  /// From a ball to a source; without sources straight up, to the disc when there is one.
  [[nodiscard]] Ray rayOf(const Sphere& ball, std::size_t source) const {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    if (sources_.empty()) {
      return {ball.centre, up_, disk_ ? core::dot(disk_->centre - ball.centre, up_) : kFar};
    }
    const Vec3 way = sources_[source].direction - ball.centre;
    return {ball.centre, core::normalised(way), core::length(way)};
  }

  /// Whether the light of the disc falls on a ball's middle; everywhere without one.
  [[nodiscard]] bool isUnderDisk(const Sphere& ball) const {
    if (!disk_) {
      return true;
    }
    const Vec3 way = disk_->centre - ball.centre;
    const double above = core::dot(way, up_);
    return above >= 0.0 && core::length(way - up_ * above) <= disk_->radius;
  }

  /// The part of all light that reaches a ball; `lightAlong` gives the part that passes along the ray to a source.
  template <typename LightAlong>
  [[nodiscard]] double arrivingLight(const Sphere& ball, const LightAlong& lightAlong) const {
    if (sources_.empty()) {
      return isUnderDisk(ball) ? lightAlong(rayOf(ball, 0), 0) : 0.0;
    }
    double arriving = 0.0;
    for (std::size_t k = 0; k < sources_.size(); ++k) {
      const LightDirection& source = sources_[k];
      arriving += source.direction == ball.centre ? source.weight : source.weight * lightAlong(rayOf(ball, k), k);
    }
    return weight_ != 0.0 ? arriving / weight_ : arriving;
  }

  void setAnswer(const turtle::QueryBatch& queries, std::size_t query, double light,
                 turtle::ReplyBatch& replies) const {
    const auto parameters = queries.parametersOf(query);
    const double taken = 1.0 - passing_;
    const double product = efficiency_ * parameters[0] / 4.0 * s_ * s_ * taken * light * light_ - parameters[1];
    replies.set(queries, query, 0, parameters[0]);
    replies.set(queries, query, 1, product);
  }

  double s_;
  double efficiency_;
  double beamRadius_;
  double passing_ = 0.0;    // part of the light that a ball lets pass
  std::int64_t limit_ = 0;  // of the number of balls on a ray
  RaySums hits_;
  std::vector<LightDirection> sources_;  // places and weights
  double weight_ = 0.0;                  // of all sources
  std::optional<Sphere> disk_;           // a flat disc across up; it replaces the sources
  double light_ = kYearlyLight;          // on a unit of area
  Vec3 up_{0.0, 1.0, 0.0};
  std::string lengthUnit_ = "m";
};

ConfigurationValues publishedDefaultsOfTakenaka() {
  return {{"sources", ConfigurationRows{{10000.0, 0.0, 0.0, 1.0}}}};
}

}  // namespace

turtle::EnvironmentDescription describeTakenaka(const std::string& lengthUnit) {
  const std::string area = lengthUnit + "^2";
  return {.name = "takenaka",
          .summary = std::string(kTakenakaSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"leafArea", area, ""}, {"maintenance", "1", ""}},
          .outputs = {{"leafArea", area, ""}, {"product", "1", ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kTakenakaProcess{
    .name = "takenaka",
    .summary = kTakenakaSummary,
    .source =
        "Takenaka 1994, A simulation model of tree architecture development based on growth response to local light "
        "environment",
    .keys = kTakenakaKeys,
    .publishedKeywords = kTakenakaPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      auto problems = problemsOfSources("takenaka", configuration.rows("sources"), false);
      const double s = configuration.number("parameterS");
      if (s * s < 1.0 - configuration.number("transmittance")) {
        problems.push_back(wrongConfiguration("takenaka",
                                              "'parameterS' is too small for the 'transmittance': a ball would take "
                                              "more light than falls on it",
                                              "parameterS * parameterS must be at least 1 - transmittance"));
      }
      if (const auto& disk = configuration.numbers("diskSource");
          !disk.empty() && (disk.size() != 4 || disk[0] < 0.0)) {
        problems.push_back(wrongConfiguration("takenaka", "'diskSource' must be a radius, at least 0, and x, y, z",
                                              "leave it out for light from 'sources'"));
      }
      const bool isCompatible = configuration.flag("compatible");
      if (auto problem = tooManyCells("takenaka", cellsOf(configuration), PublishedVoxels::kMostVoxels);
          isCompatible && problem) {
        problems.push_back(*std::move(problem));
      }
      if (!problems.empty()) {
        return tl::unexpected(std::move(problems));
      }
      if (isCompatible) {
        return makePublishedTakenaka(configuration);
      }
      return std::make_unique<Takenaka>(configuration);
    },
    .publishedDefaults = publishedDefaultsOfTakenaka};

}  // namespace espalier::environment
