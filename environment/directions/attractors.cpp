// The process `attractors` (docs/environments.md): points that pull or push, like magnets.
//
// O(n · attractors).

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/directions/direction_reply.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kAttractorsSummary = "Points that pull or push, like magnets.";
constexpr std::array kAttractorsKeys{
    ConfigurationKey{.name = "points",
                     .kind = KeyKind::Rows,
                     .description = "attractors: place x, y, z and strength; a negative one pushes away",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{.name = "exponent",
                     .description = "power of the distance with which the pull weakens; 0: not at all",
                     .minimum = 0.0,
                     .maximum = 10.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "reach",
                     .description = "distance beyond which an attractor does not act; 0: no limit",
                     .unit = "length",
                     .minimum = 0.0},
    ConfigurationKey{.name = "nearest",
                     .description = "a nearer attractor acts as from this distance",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.01},
};

struct Attractor {
  Vec3 place;
  double strength = 0.0;
};

class Attractors final : public turtle::EnvironmentProcess {
 public:
  explicit Attractors(const Configuration& configuration)
      : exponent_(configuration.number("exponent")),
        reach_(configuration.number("reach") > 0.0 ? configuration.number("reach")
                                                   : std::numeric_limits<double>::infinity()),
        nearest_(configuration.number("nearest")) {
    for (const auto& row : configuration.rows("points")) {
      attractors_.push_back({{row[0], row[1], row[2]}, row[3]});
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description{.name = "attractors",
                                               .summary = std::string(kAttractorsSummary),
                                               .needs = {.position = true},
                                               .inputs = {},
                                               .outputs = vectorOutputs("pull", "1"),
                                               .isStateful = false};
    description.outputs.push_back({"distance", lengthUnit_, ""});
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (attractors_.empty() && queries.size() > 0) {
      return turtle::EnvironmentError{
          "Environment 'attractors' has no attractors, so nothing would pull. Give 'points': [[x, y, z, strength]].",
          false};
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (queries.parametersOf(query).size() > 3) {
        replies.set(queries, query, 3, distanceAt(queries.position[query]));
      }
    }
    replyVectors(queries, replies, [this](const Vec3& place) { return pullAt(place); });
    return std::nullopt;
  }

 private:
  [[nodiscard]] Vec3 pullAt(const Vec3& place) const {
    core::pollWork();
    Vec3 pull;
    for (const Attractor& attractor : attractors_) {
      const Vec3 way = attractor.place - place;
      const double distance = core::length(way);
      if (distance > 0.0 && distance <= reach_) {
        pull = pull + way * (attractor.strength / distance / core::pow(std::max(distance, nearest_), exponent_));
      }
    }
    return pull;
  }

  [[nodiscard]] double distanceAt(const Vec3& place) const {
    core::pollWork();
    double distance = std::numeric_limits<double>::infinity();
    for (const Attractor& attractor : attractors_) {
      distance = std::min(distance, core::length(attractor.place - place));
    }
    return distance;
  }

  std::vector<Attractor> attractors_;
  double exponent_;
  double reach_;
  double nearest_;
  std::string lengthUnit_ = "m";
};

}  // namespace

extern constinit const ProcessEntry kAttractorsProcess{
    .name = "attractors",
    .summary = kAttractorsSummary,
    .source = "Espalier's own",
    .keys = kAttractorsKeys,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Attractors>(configuration);
    }};

}  // namespace espalier::environment
