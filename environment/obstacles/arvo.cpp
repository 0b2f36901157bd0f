// The process `arvo` (docs/environments.md): plants that climb on obstacles.
//
// The turtle's up vector is the normal of the surface below it. The default finds the nearest surface exactly and draws
// no random numbers. `compatible` seeks it by a ray along −up and then by `triesForSurface` random rays. O(n · tries ·
// log m) for m shapes.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/obstacles/obstacle_scene.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kArvoSummary = "The next segment of a plant that climbs on obstacles.";
constexpr std::array kArvoOwnKeys{
    ConfigurationKey{.name = "surfaceDistance",
                     .description = "distance that the plant keeps from the surface",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 0.5},
    ConfigurationKey{.name = "maxSurfaceDistance",
                     .description = "a surface further from a candidate is not found",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "triesForQ",
                     .kind = KeyKind::Integer,
                     .description = "number of directions to try, over the whole circle",
                     .minimum = 1,
                     .maximum = 100000,
                     .defaultNumber = 64},
    ConfigurationKey{.name = "triesForSurface",
                     .kind = KeyKind::Integer,
                     .description = "number of random rays for the nearest surface (only when compatible)",
                     .minimum = 0,
                     .maximum = 100000,
                     .defaultNumber = 64},
    ConfigurationKey{.name = "addObjects",
                     .kind = KeyKind::Boolean,
                     .description = "queries without parameters add solids by their following module"},
    ConfigurationKey{
        .name = "removeObjects", .kind = KeyKind::Boolean, .description = "remove added solids after the next step"},
    ConfigurationKey{.name = "seed",
                     .kind = KeyKind::Integer,
                     .description = "seed of the random rays, besides the simulation's (only when compatible)",
                     .minimum = 0},
    ConfigurationKey{
        .name = "compatible", .kind = KeyKind::Boolean, .description = "seek surfaces by random rays, as published"},
};
constexpr auto kArvoKeys = joinTables(kObstacleKeys, kArvoOwnKeys);

/// `obstacles: FILE`, a background scene.
std::string readObstacleFile(const PublishedLineInput& input) {
  const std::string name = besideFile(input.file, input.line.value);
  auto text = input.files.read(name);
  if (!text) {
    return "names the file '" + name + "', which cannot be read; it is looked for beside the specification";
  }
  input.values.insert_or_assign("scene", std::move(*text));
  return {};
}

constexpr std::array kArvoPublishedKeywords{
    PublishedKeyword{.keyword = "obstacles", .kind = PublishedKind::Own, .key = {}, .read = readObstacleFile},
    PublishedKeyword{.keyword = "surface distance", .key = "surfaceDistance"},
    PublishedKeyword{.keyword = "max surface distance", .key = "maxSurfaceDistance"},
    PublishedKeyword{.keyword = "tries for Q", .key = "triesForQ"},
    PublishedKeyword{.keyword = "tries for surface", .key = "triesForSurface"},
    PublishedKeyword{.keyword = "add objects", .kind = PublishedKind::Switch, .key = "addObjects", .onWords = kOnOrYes},
    PublishedKeyword{
        .keyword = "remove objects", .kind = PublishedKind::Switch, .key = "removeObjects", .onWords = kOnOrYes},
    PublishedKeyword{.keyword = "seed", .key = "seed"},
    // of the published program's grid, which only makes it faster
    PublishedKeyword{.keyword = "domain size", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "position", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Unused, .key = {}},
};

Vec3 rotated(const Vec3& v, const Vec3& axis, double radians) {
  const double c = core::cos(radians);
  const double s = core::sin(radians);
  return v * c + core::cross(axis, v) * s + axis * (core::dot(axis, v) * (1.0 - c));
}

struct Segment {
  Vec3 heading;
  double length = 0.0;
  Vec3 normal;
};

class Arvo final : public turtle::EnvironmentProcess {
 public:
  Arvo(ObstacleScene::Content fixed, const Configuration& configuration)
      : fixed_(std::move(fixed)),
        scene_(fixed_),
        distance_(configuration.number("surfaceDistance")),
        most_(configuration.number("maxSurfaceDistance")),
        tries_(static_cast<int>(configuration.integer("triesForQ"))),
        rays_(static_cast<int>(configuration.integer("triesForSurface"))),
        adds_(configuration.flag("addObjects")),
        forgets_(configuration.flag("removeObjects")),
        ownSeed_(static_cast<std::uint64_t>(configuration.integer("seed"))),
        isCompatible_(configuration.flag("compatible")) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "arvo",
            .summary = std::string(kArvoSummary),
            .needs = {.position = true, .heading = true, .up = true, .parameters = true, .following = adds_},
            .inputs = {{"length", lengthUnit_, ""}},
            .outputs = {{"headingX", "1", ""},
                        {"headingY", "1", ""},
                        {"headingZ", "1", ""},
                        {"length", lengthUnit_, ""},
                        {"normalX", "1", ""},
                        {"normalY", "1", ""},
                        {"normalZ", "1", ""}},
            .isStateful = adds_};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    symbols_ = context.symbols;
    seed_ = context.seed + ownSeed_;
    added_.clear();
    rebuild();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      if (count > 6) {
        setSegment(queries, query, replies);
      } else if (count > 0) {
        setHit(queries, query, replies);
      }
    }
    countAnswers(queries, replies);
    if (adds_) {
      addObjects(queries);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    if (!adds_) {
      return {};
    }
    StateWriter writer;
    writer.integer(added_.size());
    for (const Capsule& one : added_) {
      for (const double number : {one.a.x, one.a.y, one.a.z, one.b.x, one.b.y, one.b.z, one.radius}) {
        writer.number(number);
      }
    }
    return writer.take();
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    if (!adds_ && state.empty()) {
      return std::nullopt;
    }
    StateReader reader(state);
    std::vector<Capsule> added;
    bool areFinite = true;
    const std::uint64_t count = reader.integer();
    for (std::uint64_t i = 0; i < count && reader.isIntact(); ++i) {
      Capsule one;
      for (double* number : {&one.a.x, &one.a.y, &one.a.z, &one.b.x, &one.b.y, &one.b.z, &one.radius}) {
        *number = reader.number();
        areFinite = areFinite && std::isfinite(*number);
      }
      added.push_back(one);
    }
    if (!reader.isComplete() || !areFinite) {
      return turtle::EnvironmentError{
          "The saved state of environment 'arvo' is damaged. Use a snapshot that is complete.", false};
    }
    added_ = std::move(added);
    rebuild();
    return std::nullopt;
  }

 private:
  void setSegment(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) const {
    const Segment segment = segmentFrom(queries, query);
    const std::array<double, 7> values{segment.heading.x, segment.heading.y, segment.heading.z, segment.length,
                                       segment.normal.x,  segment.normal.y,  segment.normal.z};
    for (std::size_t k = 0; k < values.size(); ++k) {
      replies.set(queries, query, k, values[k]);
    }
  }

  [[nodiscard]] Segment segmentFrom(const turtle::QueryBatch& queries, std::size_t query) const {
    const Vec3& from = queries.position[query];
    const Vec3 up = core::normalised(queries.up[query]);
    const double length = queries.parametersOf(query)[0];
    for (int attempt = 0; attempt < tries_; ++attempt) {
      core::pollWork();
      // 0, one to the left, one to the right, two to the left, …
      const int side = attempt % 2 == 0 ? -attempt / 2 : (attempt + 1) / 2;
      const double angle = 2.0 * std::numbers::pi * side / tries_;
      const Vec3 candidate = from + rotated(queries.heading[query], up, angle) * length;
      const auto surface = surfaceNear(candidate, up, queries, query, attempt);
      if (!surface) {
        continue;
      }
      const Vec3 end = surface->point + surface->normal * distance_;
      const Vec3 way = end - from;
      const double reached = core::length(way);
      if (reached > 0.0 && !scene_.isInside(end) &&
          !(scene_.clearance(from, way * (1.0 / reached), reached) < reached)) {
        return {way * (1.0 / reached), reached, surface->normal};
      }
    }
    return {queries.heading[query], 0.0, up};
  }

  [[nodiscard]] std::optional<SurfacePoint> surfaceNear(const Vec3& place, const Vec3& up,
                                                        const turtle::QueryBatch& queries, std::size_t query,
                                                        int attempt) const {
    if (!isCompatible_) {
      return scene_.nearest(place, most_);
    }
    // straight down first, then the nearest that random rays find
    if (const auto hit = surfaceAlong(place, -up, most_)) {
      return hit;
    }
    std::optional<SurfacePoint> best;
    const core::CounterRandom random(seed_, queries.plant[query]);
    for (int ray = 0; ray < rays_; ++ray) {
      core::pollWork();
      const auto draw = static_cast<std::uint32_t>(2 * (attempt * rays_ + ray));
      const auto uniform = [&](std::uint32_t k) {
        return random.uniform(core::DrawDomain::Environment, static_cast<std::uint32_t>(queries.step),
                              queries.module[query], draw + k);
      };
      const double z = 2.0 * uniform(0) - 1.0;
      const double angle = 2.0 * std::numbers::pi * uniform(1);
      const double across = std::sqrt(std::max(1.0 - z * z, 0.0));
      const auto hit = surfaceAlong(place, {across * core::cos(angle), across * core::sin(angle), z}, most_);
      if (hit && (!best || hit->distance < best->distance)) {
        best = hit;
      }
    }
    return best;
  }

  /// Where a ray meets a surface, its distance along the ray.
  [[nodiscard]] std::optional<SurfacePoint> surfaceAlong(const Vec3& from, const Vec3& direction, double reach) const {
    const double way = scene_.clearance(from, direction, reach);
    const auto surface = scene_.nearest(from + direction * way, kTouch * std::max(reach, 1.0));
    if (!surface || way >= reach) {
      return std::nullopt;
    }
    return SurfacePoint{way, from + direction * way, surface->normal};
  }

  void setHit(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) const {
    const auto parameters = queries.parametersOf(query);
    const auto hit = surfaceAlong(queries.position[query], core::normalised(queries.heading[query]),
                                  std::nextafter(parameters[0], parameters[0] + 1.0));
    replies.set(queries, query, 0, hit ? 1.0 : 0.0);
    if (hit) {
      const std::array<double, 3> normal{hit->normal.x, hit->normal.y, hit->normal.z};
      for (std::size_t k = 1; k < std::min<std::size_t>(parameters.size(), 4); ++k) {
        replies.set(queries, query, k, normal[k - 1]);
      }
    }
  }

  void addObjects(const turtle::QueryBatch& queries) {
    std::vector<Capsule> added;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const core::SymbolId symbol = queries.following.empty() ? core::kNoSymbol : queries.following[query];
      if (!queries.parametersOf(query).empty() || symbol >= symbols_.size()) {
        continue;
      }
      const auto size = queries.followingParametersOf(query);
      const Vec3& from = queries.position[query];
      if (symbols_[symbol] == "S" && !size.empty()) {
        added.push_back({from, from, std::max(size[0], 0.0)});
      } else if (symbols_[symbol] == "C" && size.size() > 1) {
        added.push_back({from, from + queries.heading[query] * size[1], std::max(size[0], 0.0)});
      }
    }
    if (added.empty() && (!forgets_ || added_.empty())) {
      return;
    }
    // sorted, so that the order of queries leaves no trace
    std::sort(added.begin(), added.end(), [](const Capsule& a, const Capsule& b) {
      const auto keyOf = [](const Capsule& c) {
        return std::array{c.a.x, c.a.y, c.a.z, c.b.x, c.b.y, c.b.z, c.radius};
      };
      return keyOf(a) < keyOf(b);
    });
    if (forgets_) {
      added_.clear();
    }
    added_.insert(added_.end(), added.begin(), added.end());
    rebuild();
  }

  void rebuild() {
    ObstacleScene::Content all = fixed_;
    all.capsules.insert(all.capsules.end(), added_.begin(), added_.end());
    scene_ = ObstacleScene(std::move(all));
  }

  static constexpr double kTouch = 1e-6;  // of a surface, relative to lengths of about 1

  ObstacleScene::Content fixed_;
  ObstacleScene scene_;
  double distance_;
  double most_;
  int tries_;
  int rays_;
  bool adds_;
  bool forgets_;
  std::uint64_t ownSeed_;
  bool isCompatible_;
  std::uint64_t seed_ = 0;
  std::vector<std::string> symbols_;  // names by SymbolId
  std::vector<Capsule> added_;        // by queries, in the order of steps
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeArvo(const Configuration& configuration) {
  auto content = readObstacles("arvo", configuration);
  if (!content) {
    return tl::unexpected(std::move(content.error()));
  }
  // a plant that keeps further away than it may be would never find a place; the published program has it so
  if (!configuration.flag("compatible") &&
      configuration.number("surfaceDistance") > configuration.number("maxSurfaceDistance")) {
    return refuse("arvo", "'surfaceDistance' is larger than 'maxSurfaceDistance': no segment would be found",
                  "maxSurfaceDistance: how far from a surface the plant may be");
  }
  return std::make_unique<Arvo>(std::move(*content), configuration);
}

}  // namespace

extern constinit const ProcessEntry kArvoProcess{
    .name = "arvo",
    .summary = kArvoSummary,
    .source =
        "Arvo & Kirk 1988, Modeling plants with environment-sensitive automata; Greene 1989, Voxel space automata",
    .keys = kArvoKeys,
    .publishedKeywords = kArvoPublishedKeywords,
    .make = makeArvo};

}  // namespace espalier::environment
