// The process `shadow` (docs/environments.md): light under a canopy by shadow propagation in voxels, in the
// multiplicative form of the published program shadowpyramid.
//
// All shadows of a step are cast before any light is read. Products are fixed-point sums of logarithms, so replies do
// not depend on the order of queries, bit by bit. Shadows do not outlast the step. `compatible`: published_shadow.cpp.
// O(n shadowDepth^3) for n queries.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/bricked_grid.h"
#include "environment/geometry/world_up.h"
#include "environment/light/published_variants.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kShadowSummary =
    "Light by shadow propagation: every foliage element multiplies the light in a pyramid of voxels below it.";
constexpr std::array<std::string_view, 1> kShadowAliases{"shadowpyramid"};
constexpr std::array kShadowKeys{
    ConfigurationKey{.name = "gridSize",
                     .kind = KeyKind::Integer,
                     .description = "voxels along each side of the grid",
                     .minimum = 2,
                     .maximum = 1000,
                     .defaultNumber = 201},
    ConfigurationKey{
        .name = "gridSpan",
        .description = "half the extent of the grid: it covers -span to span across and 0 to 2 span upwards",
        .unit = "length",
        .minimum = 0.0,
        .isMinimumExclusive = true,
        .defaultNumber = 200},
    ConfigurationKey{.name = "shadowSpread",
                     .description = "voxels by which the half-width of the pyramid grows per tier",
                     .minimum = 0.0,
                     .maximum = 10.0,
                     .defaultNumber = 1},
    ConfigurationKey{.name = "shadowDepth",
                     .kind = KeyKind::Integer,
                     .description = "tiers of the pyramid, the own voxel's included",
                     .minimum = 1,
                     .maximum = 100,
                     .defaultNumber = 6},
    ConfigurationKey{.name = "shadowWeight",
                     .description = "C1: the part of the light taken in the own voxel; above 1 also nearby all of it",
                     .minimum = 0.0,
                     .defaultNumber = 0.58},
    ConfigurationKey{.name = "shadowDissipation",
                     .description = "C2: the factor by which a shadow weakens per voxel of distance",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 6.9},
    ConfigurationKey{.name = "lightRandomness",
                     .description = "largest random number added to each component of the gradient",
                     .unit = "1/length",
                     .minimum = 0.0,
                     .defaultNumber = 0},
    ConfigurationKey{.name = "lightVerticalBias",
                     .description = "number added to the gradient's component along up",
                     .unit = "1/length",
                     .defaultNumber = 0},
    ConfigurationKey{.name = "sampleRadius",
                     .description = "distance on either side of a point at which light is sampled for the gradient",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.6},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "voxels, borders and gradients as published; bias and randomness in the field"},
};
constexpr std::array kShadowPublishedKeywords{
    PublishedKeyword{.keyword = "grid size", .key = "gridSize"},
    PublishedKeyword{.keyword = "grid span", .key = "gridSpan"},
    PublishedKeyword{.keyword = "shadow spread", .key = "shadowSpread"},
    PublishedKeyword{.keyword = "shadow depth", .key = "shadowDepth"},
    PublishedKeyword{.keyword = "shadow weight", .key = "shadowWeight"},
    PublishedKeyword{.keyword = "shadow dissipation", .key = "shadowDissipation"},
    PublishedKeyword{.keyword = "light randomness", .key = "lightRandomness"},
    PublishedKeyword{.keyword = "light vertical bias", .key = "lightVerticalBias"},
    PublishedKeyword{.keyword = "sample radius", .key = "sampleRadius"},
};

struct ShadowParameters {
  std::int64_t gridSize;
  double gridSpan;
  double spread;
  std::int64_t depth;
  double weight;
  double dissipation;
  double randomness;
  double verticalBias;
  double sampleRadius;
};

/// -log2 of a product of light factors in units of 2^-40: sums of these do not depend on their order. A sum stops at
/// kDark, where the light has long vanished.
using Darkness = std::int64_t;
constexpr double kDarknessUnit = 1099511627776.0;  // 2^40
constexpr Darkness kDark = Darkness{2000} << 40;

class Shadow final : public turtle::EnvironmentProcess {
 public:
  explicit Shadow(const ShadowParameters& parameters)
      : parameters_(parameters),
        spacing_(2.0 * parameters.gridSpan / static_cast<double>(parameters.gridSize - 1)),
        grid_(parameters.gridSize) {
    // one factor for each squared distance in the pyramid
    const std::int64_t reach = halfWidth(parameters_.depth - 1);
    const std::int64_t last = (parameters_.depth - 1) * (parameters_.depth - 1) + 2 * reach * reach;
    for (std::int64_t squared = 0; squared <= last; ++squared) {
      const double distance = std::sqrt(static_cast<double>(squared));
      const double factor = 1.0 - parameters_.weight * core::pow(parameters_.dissipation, -distance);
      darknessOf_.push_back(factor > 0.0 ? static_cast<Darkness>(std::llround(-core::log2(factor) * kDarknessUnit))
                                         : kDark);
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeShadow(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("shadow", context.world);
    if (!axes) {
      return axes.error();
    }
    axes_ = *axes;
    seed_ = context.seed;
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    // all shadows first, then all answers
    grid_.clear();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > 0.0) {
        castShadow(axes_.toGrid(queries.position[query]));
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      const Vec3 point = axes_.toGrid(queries.position[query]);
      if (count > 0) {
        replies.set(queries, query, 0, lightAt(point));
      }
      if (count > 1) {
        setGradient(queries, query, gradientAt(point), std::min<std::size_t>(count - 1, 3), replies);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::int64_t halfWidth(std::int64_t tier) const {
    return static_cast<std::int64_t>(static_cast<double>(tier) * parameters_.spread);
  }

  /// A grid coordinate in voxels: 0 at the first voxel's centre.
  [[nodiscard]] Vec3 voxelsOf(const Vec3& p) const {
    const double span = parameters_.gridSpan;
    return {(p.x + span) / spacing_, p.y / spacing_, (p.z + span) / spacing_};
  }

  /// The voxel nearest to a coordinate, half-way the one further from the grid's centre; far outside, some voxel
  /// outside.
  [[nodiscard]] std::int64_t nearestVoxel(double coordinate) const {
    const double centre = static_cast<double>(parameters_.gridSize - 1) / 2.0;
    const double bounded = std::clamp(coordinate, -1e6, 1e6);
    const double lower = std::floor(bounded);
    const double above = bounded - lower;
    const bool isUpper = above > 0.5 || (above == 0.5 && bounded >= centre);
    return static_cast<std::int64_t>(lower) + (isUpper ? 1 : 0);
  }

  void castShadow(const Vec3& point) {
    const Vec3 voxels = voxelsOf(point);
    const std::int64_t x = nearestVoxel(voxels.x);
    const std::int64_t y = nearestVoxel(voxels.y);
    const std::int64_t z = nearestVoxel(voxels.z);
    const std::int64_t last = parameters_.gridSize - 1;
    for (std::int64_t tier = 0; tier < parameters_.depth; ++tier) {
      core::pollWork();
      if (y - tier < 0 || y - tier > last) {
        continue;
      }
      const std::int64_t width = halfWidth(tier);
      for (std::int64_t i = std::max(x - width, std::int64_t{0}); i <= std::min(x + width, last); ++i) {
        const std::int64_t firstZ = std::max(z - width, std::int64_t{0});
        const std::int64_t endZ = std::min(z + width, last) + 1;
        const Darkness* const darknessOf = darknessOf_.data() + tier * tier + (i - x) * (i - x);
        for (std::int64_t k = firstZ; k < endZ;) {
          for (Darkness& darkness : grid_.run(i, y - tier, k, endZ)) {
            darkness = std::min(darkness + darknessOf[(k - z) * (k - z)], kDark);
            ++k;
          }
        }
      }
    }
  }

  [[nodiscard]] double lightOfVoxel(std::int64_t x, std::int64_t y, std::int64_t z) const {
    const Darkness darkness = grid_.get(x, y, z);
    return darkness == 0 ? 1.0 : core::exp2(-static_cast<double>(darkness) / kDarknessUnit);
  }

  [[nodiscard]] double lightAt(const Vec3& point) const {
    const Vec3 voxels = voxelsOf(point);
    const double size = static_cast<double>(parameters_.gridSize);
    if (!(voxels.x > -1.0 && voxels.x < size && voxels.y > -1.0 && voxels.y < size && voxels.z > -1.0 &&
          voxels.z < size)) {
      return 1.0;
    }
    const double x = std::floor(voxels.x);
    const double y = std::floor(voxels.y);
    const double z = std::floor(voxels.z);
    double light = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const int dx = corner & 1;
      const int dy = (corner >> 1) & 1;
      const int dz = (corner >> 2) & 1;
      const double weight = (dx == 1 ? voxels.x - x : 1.0 - (voxels.x - x)) *
                            (dy == 1 ? voxels.y - y : 1.0 - (voxels.y - y)) *
                            (dz == 1 ? voxels.z - z : 1.0 - (voxels.z - z));
      light += weight * lightOfVoxel(static_cast<std::int64_t>(x) + dx, static_cast<std::int64_t>(y) + dy,
                                     static_cast<std::int64_t>(z) + dz);
    }
    return light;
  }

  /// In grid directions, with the bias, without the random part.
  [[nodiscard]] Vec3 gradientAt(const Vec3& p) const {
    const double r = parameters_.sampleRadius;
    const double width = 2.0 * r;
    return {(lightAt({p.x + r, p.y, p.z}) - lightAt({p.x - r, p.y, p.z})) / width,
            (lightAt({p.x, p.y + r, p.z}) - lightAt({p.x, p.y - r, p.z})) / width + parameters_.verticalBias,
            (lightAt({p.x, p.y, p.z + r}) - lightAt({p.x, p.y, p.z - r})) / width};
  }

  void setGradient(const turtle::QueryBatch& queries, std::size_t query, const Vec3& gridGradient, std::size_t count,
                   turtle::ReplyBatch& replies) const {
    const Vec3 gradient = axes_.toWorld(gridGradient);
    const std::array<double, 3> components{gradient.x, gradient.y, gradient.z};
    const core::CounterRandom random(seed_, queries.plant[query]);
    for (std::uint32_t k = 0; k < count; ++k) {
      double noise = 0.0;
      if (parameters_.randomness > 0.0) {
        const double draw = random.uniform(core::DrawDomain::Environment, static_cast<std::uint32_t>(queries.step),
                                           queries.module[query], k);
        noise = parameters_.randomness * (2.0 * draw - 1.0);
      }
      replies.set(queries, query, 1 + k, components[k] + noise);
    }
  }

  ShadowParameters parameters_;
  double spacing_;                    // between voxel centres
  std::vector<Darkness> darknessOf_;  // of a shadow by squared distance in voxels
  BrickedGrid<Darkness> grid_;        // x, y up, z
  GridAxes axes_;
  std::uint64_t seed_ = 0;
  std::string lengthUnit_ = "m";
};

}  // namespace

turtle::EnvironmentDescription describeShadow(const std::string& lengthUnit) {
  const std::string perLength = "1/" + lengthUnit;
  return {.name = "shadow",
          .summary = std::string(kShadowSummary),
          .needs = {.position = true, .parameters = true},
          .inputs = {{"castsShadow", "1", ""}},
          .outputs = {{"light", "1", ""},
                      {"gradientX", perLength, ""},
                      {"gradientY", perLength, ""},
                      {"gradientZ", perLength, ""}},
          .isStateful = false};
}

extern constinit const ProcessEntry kShadowProcess{
    .name = "shadow",
    .summary = kShadowSummary,
    .source =
        "Palubicki et al. 2009, Self-organizing tree models for image synthesis, as the published program "
        "shadowpyramid has it",
    .aliases = kShadowAliases,
    .keys = kShadowKeys,
    .publishedKeywords = kShadowPublishedKeywords,
    .make = [](const Configuration& c) -> ProcessOrErrors {
      if (c.flag("compatible")) {
        return makePublishedShadow(c);
      }
      return std::make_unique<Shadow>(ShadowParameters{.gridSize = c.integer("gridSize"),
                                                       .gridSpan = c.number("gridSpan"),
                                                       .spread = c.number("shadowSpread"),
                                                       .depth = c.integer("shadowDepth"),
                                                       .weight = c.number("shadowWeight"),
                                                       .dissipation = c.number("shadowDissipation"),
                                                       .randomness = c.number("lightRandomness"),
                                                       .verticalBias = c.number("lightVerticalBias"),
                                                       .sampleRadius = c.number("sampleRadius")});
    }};

}  // namespace espalier::environment
