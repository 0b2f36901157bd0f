// The process `obstacles` (docs/environments.md): may this segment grow, and what is near?
//
// Segments that want to grow into each other block both, so the order of queries does not matter. All decisions are in
// double precision. O((n + m) log (n + m)) for n queries and m shapes, triangles and remembered segments that do not
// all overlap.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine/core/work_meter.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/geometry/segment_trees.h"
#include "environment/obstacles/obstacle_scene.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kObstaclesSummary =
    "Whether a segment may grow past obstacles and other plants, and the nearest obstacle.";
constexpr std::array<std::string_view, 4> kPlants{"ignored", "proposed", "remembered", "drawn"};
constexpr std::array kObstaclesOwnKeys{
    ConfigurationKey{.name = "reach",
                     .description = "distance beyond which obstacles do not count",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1000.0},
    ConfigurationKey{.name = "plants",
                     .kind = KeyKind::Choice,
                     .description = "which segments of other plants block: none, those of the same step, also all that "
                                    "have grown here, or also all that the plants draw",
                     .defaultText = "ignored",
                     .choices = kPlants},
};
constexpr auto kObstaclesKeys = joinTables(kObstacleKeys, kObstaclesOwnKeys);

class Obstacles final : public turtle::EnvironmentProcess {
 public:
  Obstacles(ObstacleScene scene, const Configuration& configuration)
      : scene_(std::move(scene)),
        reach_(configuration.number("reach")),
        minds_(configuration.text("plants") != "ignored"),
        remembers_(configuration.text("plants") == "remembered"),
        looks_(configuration.text("plants") == "drawn") {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "obstacles",
            .summary = std::string(kObstaclesSummary),
            .needs = {.position = true, .heading = true, .parameters = true, .geometry = looks_},
            .inputs = {{"length", lengthUnit_, ""}, {"radius", lengthUnit_, ""}},
            .outputs = {{"mayGrow", "1", ""},
                        {"distance", lengthUnit_, ""},
                        {"nearestX", lengthUnit_, ""},
                        {"nearestY", lengthUnit_, ""},
                        {"nearestZ", lengthUnit_, ""},
                        {"normalX", "1", ""},
                        {"normalY", "1", ""},
                        {"normalZ", "1", ""},
                        {"freeLength", lengthUnit_, ""},
                        {"longestSegment", lengthUnit_, ""}},
            .isStateful = remembers_};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    grown_.clear();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (looks_ && queries.geometry == nullptr) {
      return turtle::EnvironmentError{
          "Environment 'obstacles' needs the geometry of the plants, which did not come with the queries. Set 'plants' "
          "to "
          "\"remembered\" instead of \"drawn\" where it cannot be sent.",
          false};
    }
    // the segments that want to grow now, and those that exist
    std::vector<PlantSegment> others;
    if (minds_) {
      for (std::size_t query = 0; query < queries.size(); ++query) {
        const auto parameters = queries.parametersOf(query);
        if (!parameters.empty() && parameters[0] > 0.0) {
          others.push_back({queries.plant[query], segmentOf(queries, query)});
        }
      }
    }
    if (looks_) {
      appendDrawn(*queries.geometry, others);
    }
    SegmentTrees present;
    present.add(others);
    const auto isClear = [&](std::uint32_t plant, const Capsule& segment) {
      return scene_.isClear(segment.a, segment.b, segment.radius) && present.isClear(plant, segment) &&
             grown_.isClear(plant, segment);
    };
    std::vector<std::size_t> free;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      core::pollWork();
      const std::size_t count = queries.parametersOf(query).size();
      if (count == 0) {
        continue;
      }
      const bool mayGrow = isClear(queries.plant[query], segmentOf(queries, query));
      replies.set(queries, query, 0, mayGrow ? 1.0 : 0.0);
      if (mayGrow && queries.parametersOf(query)[0] > 0.0 && queries.isTransient[query] == 0) {
        free.push_back(query);
      }
      setSurroundings(queries, query, count, replies);
      if (count > 9) {
        replies.set(queries, query, 9, longestSegment(queries, query, isClear));
      }
    }
    if (remembers_) {
      // in the order of plants and modules, whatever that of the queries
      std::sort(free.begin(), free.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(queries.plant[a], queries.module[a]) < std::pair(queries.plant[b], queries.module[b]);
      });
      std::vector<PlantSegment> grown;
      grown.reserve(free.size());
      for (const std::size_t query : free) {
        grown.push_back({queries.plant[query], segmentOf(queries, query)});
      }
      grown_.add(grown);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    if (!remembers_) {
      return {};
    }
    StateWriter writer;
    writer.integer(grown_.segments().size());
    for (const auto& [plant, capsule] : grown_.segments()) {
      writer.integer(plant);
      for (const double number :
           {capsule.a.x, capsule.a.y, capsule.a.z, capsule.b.x, capsule.b.y, capsule.b.z, capsule.radius}) {
        writer.number(number);
      }
    }
    return writer.take();
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    if (!remembers_ && state.empty()) {
      return std::nullopt;
    }
    StateReader reader(state);
    std::vector<PlantSegment> grown;
    bool areFinite = true;
    const std::uint64_t count = reader.integer();
    for (std::uint64_t i = 0; i < count && reader.isIntact(); ++i) {
      PlantSegment one;
      one.plant = static_cast<std::uint32_t>(reader.integer());
      for (double* number : {&one.capsule.a.x, &one.capsule.a.y, &one.capsule.a.z, &one.capsule.b.x, &one.capsule.b.y,
                             &one.capsule.b.z, &one.capsule.radius}) {
        *number = reader.number();
        areFinite = areFinite && std::isfinite(*number);
      }
      grown.push_back(one);
    }
    if (!reader.isComplete() || !areFinite) {
      return turtle::EnvironmentError{
          "The saved state of environment 'obstacles' is damaged. Use a snapshot that is complete.", false};
    }
    grown_.clear();
    grown_.add(grown);
    return std::nullopt;
  }

 private:
  static Capsule segmentOf(const turtle::QueryBatch& queries, std::size_t query) {
    const auto parameters = queries.parametersOf(query);
    const double length = std::max(parameters[0], 0.0);
    const double radius = parameters.size() > 1 ? std::max(parameters[1], 0.0) : 0.0;
    const Vec3& from = queries.position[query];
    return {from, from + queries.heading[query] * length, radius};
  }

  /// The segments that plants draw: as thick as at their thicker end, lines of so many pixels without thickness.
  static void appendDrawn(const turtle::Geometry& geometry, std::vector<PlantSegment>& segments) {
    for (std::size_t k = 0; k < geometry.start.size(); ++k) {
      const double width = geometry.areWidthsPixels ? 0.0 : std::max(geometry.startWidth[k], geometry.endWidth[k]);
      segments.push_back({geometry.segments.plant[k], {geometry.start[k], geometry.end[k], width / 2.0}});
    }
  }

  /// How long a segment of the query's radius along its heading may be, at most `reach_`; 0 when not even its beginning
  /// is clear. Doubled until it is not clear, then halved to the last bit.
  template <typename IsClear>
  [[nodiscard]] double longestSegment(const turtle::QueryBatch& queries, std::size_t query,
                                      const IsClear& isClear) const {
    const Capsule asked = segmentOf(queries, query);
    const Vec3 heading = core::normalised(queries.heading[query]);
    const auto isClearUpTo = [&](double clear, double length) {
      return isClear(queries.plant[query], {asked.a + heading * clear, asked.a + heading * length, asked.radius});
    };
    if (!isClearUpTo(0.0, 0.0)) {
      return 0.0;
    }
    double clear = 0.0;
    double blocked = std::min(std::max(core::length(asked.b - asked.a), reach_ / 1024.0), reach_);
    while (isClearUpTo(clear, blocked)) {
      if (blocked == reach_) {
        return reach_;
      }
      clear = blocked;
      blocked = std::min(2.0 * blocked, reach_);
    }
    for (double middle = (clear + blocked) / 2.0; middle > clear && middle < blocked;
         middle = (clear + blocked) / 2.0) {
      (isClearUpTo(clear, middle) ? clear : blocked) = middle;
    }
    return clear;
  }

  void setSurroundings(const turtle::QueryBatch& queries, std::size_t query, std::size_t count,
                       turtle::ReplyBatch& replies) const {
    const Vec3& position = queries.position[query];
    if (count > 1) {
      const auto surface = scene_.nearest(position, reach_);
      replies.set(queries, query, 1, surface ? surface->distance : reach_);
      if (surface) {
        const std::array<double, 6> values{surface->point.x,  surface->point.y,  surface->point.z,
                                           surface->normal.x, surface->normal.y, surface->normal.z};
        for (std::size_t k = 2; k < std::min<std::size_t>(count, 8); ++k) {
          replies.set(queries, query, k, values[k - 2]);
        }
      }
    }
    if (count > 8) {
      replies.set(queries, query, 8, scene_.clearance(position, core::normalised(queries.heading[query]), reach_));
    }
  }

  ObstacleScene scene_;
  double reach_;
  bool minds_;
  bool remembers_;
  bool looks_;
  SegmentTrees grown_;  // in the order of growth
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeObstacles(const Configuration& configuration) {
  auto content = readObstacles("obstacles", configuration);
  if (!content) {
    return tl::unexpected(std::move(content.error()));
  }
  return std::make_unique<Obstacles>(ObstacleScene(std::move(*content)), configuration);
}

}  // namespace

extern constinit const ProcessEntry kObstaclesProcess{.name = "obstacles",
                                                      .summary = kObstaclesSummary,
                                                      .source = "Espalier's own",
                                                      .keys = kObstaclesKeys,
                                                      .make = makeObstacles};

}  // namespace espalier::environment
