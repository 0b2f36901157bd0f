#include "environment/obstacles.h"

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "environment/box_tree.h"
#include "environment/obstacle_scene.h"
#include "environment/replies.h"
#include "environment/state_bytes.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kSummary = "Whether a segment may grow past obstacles and other plants, and what is near.";
constexpr std::array<std::string_view, 3> kPlants{"ignored", "proposed", "remembered"};
constexpr std::array kKeys{
    kPlanesKey,
    kBoxesKey,
    kSpheresKey,
    kCapsulesKey,
    kHeightsKey,
    kHeightsExtentKey,
    kVerticesKey,
    kTrianglesKey,
    kMeshKey,
    kSceneKey,
    ConfigurationKey{.name = "reach",
                     .description = "largest distance that is looked at",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1000.0},
    ConfigurationKey{.name = "plants",
                     .kind = KeyKind::Choice,
                     .description = "which segments of other plants block: none, those of the same step, or also all "
                                    "that have grown",
                     .defaultText = "ignored",
                     .choices = kPlants},
};

struct Grown {
  std::uint32_t plant = 0;
  Capsule capsule;
};

class Obstacles final : public turtle::EnvironmentProcess {
 public:
  Obstacles(ObstacleScene scene, const Configuration& configuration)
      : scene_(std::move(scene)),
        reach_(configuration.number("reach")),
        minds_(configuration.text("plants") != "ignored"),
        remembers_(configuration.text("plants") == "remembered") {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "obstacles",
            .summary = std::string(kSummary),
            .needs = {.position = true, .heading = true, .parameters = true},
            .inputs = {{"length", lengthUnit_, ""}, {"radius", lengthUnit_, ""}},
            .outputs = {{"mayGrow", "1", ""},
                        {"distance", lengthUnit_, ""},
                        {"nearestX", lengthUnit_, ""},
                        {"nearestY", lengthUnit_, ""},
                        {"nearestZ", lengthUnit_, ""},
                        {"normalX", "1", ""},
                        {"normalY", "1", ""},
                        {"normalZ", "1", ""},
                        {"freeLength", lengthUnit_, ""}},
            .isStateful = remembers_};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    grown_.clear();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    // what grew before, then what wants to grow now
    std::vector<Grown> segments = grown_;
    std::vector<std::size_t> queryOf(segments.size(), queries.size());
    if (minds_) {
      for (std::size_t query = 0; query < queries.size(); ++query) {
        const auto parameters = queries.parametersOf(query);
        if (!parameters.empty() && parameters[0] > 0.0) {
          segments.push_back({queries.plant[query], segmentOf(queries, query)});
          queryOf.push_back(query);
        }
      }
    }
    std::vector<Bounds> boxes;
    for (const Grown& segment : segments) {
      boxes.push_back(boundsOf(segment.capsule));
    }
    const BoxTree tree(boxes);
    std::vector<std::size_t> free;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      if (count == 0) {
        continue;
      }
      const Capsule segment = segmentOf(queries, query);
      const bool mayGrow = scene_.isClear(segment.a, segment.b, segment.radius) &&
                           isClearOfPlants(tree, segments, queries.plant[query], segment);
      replies.set(queries, query, 0, mayGrow ? 1.0 : 0.0);
      if (mayGrow && queries.parametersOf(query)[0] > 0.0 && queries.isTransient[query] == 0) {
        free.push_back(query);
      }
      setSurroundings(queries, query, count, replies);
    }
    if (remembers_) {
      // in the order of plants and modules, whatever that of the queries
      std::sort(free.begin(), free.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(queries.plant[a], queries.module[a]) < std::pair(queries.plant[b], queries.module[b]);
      });
      for (const std::size_t query : free) {
        grown_.push_back({queries.plant[query], segmentOf(queries, query)});
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    if (!remembers_) {
      return {};
    }
    StateWriter writer;
    writer.integer(grown_.size());
    for (const auto& [plant, capsule] : grown_) {
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
    std::vector<Grown> grown;
    const std::uint64_t count = reader.integer();
    for (std::uint64_t i = 0; i < count && reader.isIntact(); ++i) {
      Grown one;
      one.plant = static_cast<std::uint32_t>(reader.integer());
      for (double* number : {&one.capsule.a.x, &one.capsule.a.y, &one.capsule.a.z, &one.capsule.b.x, &one.capsule.b.y,
                             &one.capsule.b.z, &one.capsule.radius}) {
        *number = reader.number();
      }
      grown.push_back(one);
    }
    if (!reader.isComplete()) {
      return turtle::EnvironmentError{
          "The saved state of environment 'obstacles' is damaged. Use a snapshot that is complete.", false};
    }
    grown_ = std::move(grown);
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

  static bool isClearOfPlants(const BoxTree& tree, const std::vector<Grown>& segments, std::uint32_t plant,
                              const Capsule& segment) {
    bool isClear = true;
    const double around = core::length(segment.b - segment.a) * 0.5 + segment.radius;
    tree.visitNear((segment.a + segment.b) * 0.5, around, [&](std::size_t index) {
      const auto& [otherPlant, other] = segments[index];
      isClear = isClear && (otherPlant == plant ||
                            segmentDistance(segment.a, segment.b, other.a, other.b) > segment.radius + other.radius);
      return isClear ? around : 0.0;
    });
    return isClear;
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
  std::vector<Grown> grown_;  // in the order of growth
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeObstacles(const Configuration& configuration) {
  auto content = readObstacles("obstacles", configuration);
  if (auto* errors = std::get_if<std::vector<core::Diagnostic>>(&content)) {
    return std::move(*errors);
  }
  return std::make_unique<Obstacles>(ObstacleScene(std::get<ObstacleScene::Content>(std::move(content))),
                                     configuration);
}

}  // namespace

constinit const ProcessEntry kObstaclesProcess{
    .name = "obstacles", .summary = kSummary, .aliases = {}, .keys = kKeys, .fieldKeywords = {}, .make = makeObstacles};

}  // namespace espalier::environment
