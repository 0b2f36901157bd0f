// The process `chiba` (docs/environments.md): light that reaches leaf spheres past each other.
//
// Directions are the `sources` or, without any, the middles of the triangles of an octahedron that is subdivided until
// there are `sampleCount`. Light below 1e-12 counts as none. `compatible`: published_chiba.cpp. O(n · directions · (1 +
// spheres met)) with columns along each direction. Spheres of very different sizes, and steps in which few change, are
// looked up in a tree of boxes.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
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

constexpr std::string_view kChibaSummary = "Light that reaches leaf spheres past each other.";
constexpr double kChibaDarkness = 1e-12;

constexpr std::array kChibaKeys{
    ConfigurationKey{.name = "sampleCount",
                     .kind = KeyKind::Integer,
                     .description = "light directions when no sources are given, rounded up to 8, 32, 128, …",
                     .minimum = 1,
                     .maximum = 32768,
                     .defaultNumber = 20},
    ConfigurationKey{.name = "lowerToUpperRatio",
                     .description = "brightness from below relative to that from above, without sources",
                     .minimum = 0.0,
                     .defaultNumber = 0.7},
    ConfigurationKey{.name = "overcastSky",
                     .kind = KeyKind::Boolean,
                     .description = "the CIE overcast sky instead of a uniform one, without sources"},
    ConfigurationKey{.name = "sources",
                     .kind = KeyKind::Rows,
                     .description = "light directions: x, y, z towards the light and a weight",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{.name = "transmittance",
                     .description = "part of the light that passes through the middle of a sphere",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.6},
    ConfigurationKey{.name = "radius",
                     .description = "radius of a sphere whose query sends no positive radius",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 25},
    ConfigurationKey{.name = "beamRadius",
                     .description = "radius of a beam relative to the sphere's that it reaches; it widens the others",
                     .minimum = 0.0},
    ConfigurationKey{.name = "estimateIntersectionArea",
                     .kind = KeyKind::Boolean,
                     .description = "light lost by the area that the spheres' discs have in common along a ray"},
    gridSizeKey(kUnitSides, "voxels along x, y, z of the published traversal (only when compatible)"),
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "as the published program, which misses spheres"},
};
constexpr std::array kChibaPublishedKeywords{
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Numbers, .key = "gridSize", .count = 3},
    PublishedKeyword{.keyword = "number of samples", .key = "sampleCount"},
    PublishedKeyword{.keyword = "lower to upper ratio", .key = "lowerToUpperRatio"},
    PublishedKeyword{
        .keyword = "use CIE formula", .kind = PublishedKind::Switch, .key = "overcastSky", .onWords = kYes},
    PublishedKeyword{.keyword = "source direction", .kind = PublishedKind::Row, .key = "sources", .count = 4},
    PublishedKeyword{.keyword = "transmittance", .key = "transmittance"},
    PublishedKeyword{.keyword = "radius", .key = "radius"},
    PublishedKeyword{.keyword = "beam radius", .key = "beamRadius"},
    PublishedKeyword{.keyword = "estimate intersection area",
                     .kind = PublishedKind::Switch,
                     .key = "estimateIntersectionArea",
                     .onWords = kOn},
};

/// Area that two discs have in common whose middles are `d` apart.
double commonArea(double r1, double r2, double d) {
  const double small = std::min(r1, r2);
  if (d >= r1 + r2) {
    return 0.0;
  }
  if (d <= std::abs(r1 - r2)) {
    return std::numbers::pi * small * small;
  }
  // two segments of circles, cut off by the line through the intersections
  const double d1 = (d * d + r1 * r1 - r2 * r2) / (2.0 * d);
  const double d2 = d - d1;
  const auto segment = [](double r, double h) {
    return r * r * core::acos(std::clamp(h / r, -1.0, 1.0)) - h * std::sqrt(std::max(r * r - h * h, 0.0));
  };
  return segment(r1, d1) + segment(r2, d2);
}

using ChibaAnswer = std::array<double, 4>;  // light and its mean direction

class Chiba final : public turtle::EnvironmentProcess {
 public:
  explicit Chiba(const Configuration& configuration)
      : sky_{.sampleCount = static_cast<std::size_t>(configuration.integer("sampleCount")),
             .lowerToUpperRatio = configuration.number("lowerToUpperRatio"),
             .isOvercast = configuration.flag("overcastSky")},
        transmittance_(configuration.number("transmittance")),
        radius_(configuration.number("radius")),
        beamRadius_(configuration.number("beamRadius")),
        estimatesArea_(configuration.flag("estimateIntersectionArea")) {
    for (const auto& row : configuration.rows("sources")) {
      sources_.push_back({{row[0], row[1], row[2]}, row[3]});
    }
    normaliseLight(sources_);
    // the finest unit with which the chords that make darkness can still be added up
    const double longest = transmittance_ < 1.0 ? core::log(kChibaDarkness) / core::log(transmittance_) : 1.0;
    diameter_ = core::exp2(std::clamp(61.0 - std::ceil(core::log2(std::max(longest, 1.0))), 40.0, 56.0));
    limit_ =
        transmittance_ < 1.0 ? static_cast<std::int64_t>(std::min(longest * diameter_, 0x1p62)) : RaySums::kMostLimit;
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeChiba(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("chiba", context.world);
    if (!up) {
      return up.error();
    }
    lengthUnit_ = context.world.lengthUnit;
    chords_.clear();
    directions_ = sources_.empty() ? sampleSky(sky_, *up) : sources_;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Sphere> spheres;
    std::vector<std::size_t> queryOf;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty()) {
        spheres.push_back({queries.position[query], parameters[0] > 0.0 ? parameters[0] : radius_});
        queryOf.push_back(query);
      }
    }
    const DistinctSpheres distinct = distinctSpheres(spheres);
    const std::vector<ChibaAnswer> answers = estimatesArea_ ? answersByAreas(distinct) : answersByChords(distinct);
    for (std::size_t sphere = 0; sphere < spheres.size(); ++sphere) {
      setAnswer(queries, queryOf[sphere], answers[distinct.indexOf[sphere]], replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  /// The part of the light for one sphere that the disc of another lets pass along a ray.
  [[nodiscard]] double passing(const Sphere& own, const Sphere& other, const Vec3& direction) const {
    const Vec3 between = other.centre - own.centre;
    const double ahead = core::dot(between, direction);
    if (!(ahead > 0.0)) {
      return 1.0;
    }
    const double squared = std::max(core::dot(between, between) - ahead * ahead, 0.0);
    const double area = commonArea(own.radius, other.radius, std::sqrt(squared));
    const double whole = std::numbers::pi * own.radius * own.radius;
    return whole > 0.0 ? 1.0 - (1.0 - transmittance_) * area / whole : 1.0;
  }

  /// How far a ray from the middle of one sphere goes through another, in diameters of that.
  [[nodiscard]] double chordOf(const Sphere& own, const Sphere& other, const Vec3& direction) const {
    const Vec3 between = other.centre - own.centre;
    const double ahead = core::dot(between, direction);
    const double squared = std::max(core::dot(between, between) - ahead * ahead, 0.0);
    const double radius = other.radius + beamRadius_ * own.radius;
    if (!(squared < radius * radius)) {
      return 0.0;
    }
    const double half = std::sqrt(radius * radius - squared);
    const double chord = ahead + half - std::max(ahead - half, 0.0);
    if (!(chord > 0.0 && half > 0.0)) {
      return 0.0;
    }
    // the square of a huge radius is no number: such a sphere is crossed as if through its middle
    return std::isfinite(chord) ? chord / (2.0 * radius) : 1.0;
  }

  /// The light of every sphere, by chords that are kept from step to step.
  [[nodiscard]] std::vector<ChibaAnswer> answersByChords(const DistinctSpheres& distinct) {
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    std::vector<ChibaAnswer> answers(distinct.spheres.size());
    chords_.update(distinct,
                   RaySums::Rays{directions_.size(), limit_,
                                 [&](const Sphere& own, std::size_t k) {
                                   return Ray{own.centre, directions_[k].direction, kEndless};
                                 },
                                 [&](const Sphere& own) { return beamRadius_ * own.radius; },
                                 [&](const Sphere& own, const Sphere& other, const Ray& ray) {
                                   return static_cast<std::int64_t>(chordOf(own, other, ray.direction) * diameter_);
                                 },
                                 true},
                   [&](std::uint32_t index, std::span<const std::int64_t> sums) {
                     std::size_t k = 0;
                     answers[index] = answerFrom([&](const Vec3&) {
                       const std::int64_t sum = sums[k++];
                       const double light =
                           sum == 0 ? 1.0 : core::pow(transmittance_, static_cast<double>(sum) / diameter_);
                       return sum != RaySums::kBeyond && light > kChibaDarkness ? light : 0.0;
                     });
                   });
    return answers;
  }

  /// The same by the areas in common: a product of factors of any size, computed again in every step.
  [[nodiscard]] std::vector<ChibaAnswer> answersByAreas(const DistinctSpheres& distinct) const {
    const SphereTree tree(distinct.spheres);
    std::vector<ChibaAnswer> answers(distinct.spheres.size());
    for (const std::uint32_t index : tree.order()) {
      core::pollWork();
      const Sphere& own = distinct.spheres[index];
      answers[index] = answerFrom([&](const Vec3& direction) {
        double light = 1.0;
        tree.visitRay({own.centre, direction, std::numeric_limits<double>::infinity()}, own.radius,
                      [&](std::uint32_t other, const Sphere& sphere) {
                        const std::uint32_t times = distinct.count[other] - (other == index ? 1U : 0U);
                        const double factor = times == 0 ? 1.0 : passing(own, sphere, direction);
                        for (std::uint32_t k = 0; k < times; ++k) {
                          light *= factor;
                        }
                        return light > kChibaDarkness;
                      });
        return light > kChibaDarkness ? light : 0.0;
      });
    }
    return answers;
  }

  /// From the light that is left in each direction.
  template <typename LightFrom>
  [[nodiscard]] ChibaAnswer answerFrom(const LightFrom& lightFrom) const {
    double light = 0.0;
    Vec3 brightest;
    for (const LightDirection& source : directions_) {
      const double arriving = source.weight * lightFrom(source.direction);
      light += arriving;
      brightest = brightest + source.direction * arriving;
    }
    const Vec3 unit = core::normalised(brightest);
    return {light, unit.x, unit.y, unit.z};
  }

  static void setAnswer(const turtle::QueryBatch& queries, std::size_t query, const ChibaAnswer& answer,
                        turtle::ReplyBatch& replies) {
    for (std::size_t k = 0; k < std::min<std::size_t>(queries.parametersOf(query).size(), 4); ++k) {
      replies.set(queries, query, k, answer[k]);
    }
  }

  SkyShape sky_;
  std::vector<LightDirection> sources_;
  double transmittance_;
  double radius_;
  double beamRadius_;
  bool estimatesArea_;
  double diameter_ = 1.0;   // units of the sums of chords in a sphere's diameter, a power of 2
  std::int64_t limit_ = 0;  // of a sum of chords, behind which it is dark
  RaySums chords_;
  std::vector<LightDirection> directions_;
  std::string lengthUnit_ = "m";
};

}  // namespace

turtle::EnvironmentDescription describeChiba(const std::string& lengthUnit) {
  return {.name = "chiba",
          .summary = std::string(kChibaSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"radius", lengthUnit, ""}},
          .outputs = {{"light", "1", ""}, {"brightestX", "1", ""}, {"brightestY", "1", ""}, {"brightestZ", "1", ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kChibaProcess{
    .name = "chiba",
    .summary = kChibaSummary,
    .source =
        "Chiba, Ohshida, Muraoka, Miura & Saito 1994, A growth model having the abilities of growth-regulations for "
        "simulating visual nature of botanical trees",
    .keys = kChibaKeys,
    .publishedKeywords = kChibaPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      if (auto problems = problemsOfSources("chiba", configuration.rows("sources"), true); !problems.empty()) {
        return tl::unexpected(std::move(problems));
      }
      if (configuration.flag("compatible")) {
        if (auto problem = tooManyCells("chiba", cellsOf(configuration), PublishedVoxels::kMostVoxels)) {
          return tl::unexpected(std::vector{*std::move(problem)});
        }
        return makePublishedChiba(configuration);
      }
      return std::make_unique<Chiba>(configuration);
    }};

}  // namespace espalier::environment
