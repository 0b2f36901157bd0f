// The process `colonization` (docs/environments.md): buds compete for space that is marked by points.
//
// First all queries of a step take the markers around them away, then all buds perceive, so the order of queries does
// not matter. Random markers depend on the simulation's seed only. O(n · free markers within reach); memory and the
// base cost of a step are O(markers).

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/competition/marker_grid.h"
#include "environment/geometry/spatial_cells.h"
#include "environment/obstacles/obstacle_scene.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kColonizationSummary = "Space that is marked by points, which buds occupy and compete for.";
constexpr std::array kMarkerBox{-5.0, 0.0, -5.0, 5.0, 10.0, 5.0};
constexpr double kMostMarkers = 1e7;
constexpr std::uint64_t kTriesPerMarker = 1000;
constexpr double kEveryDirection = -2.0;  // a cosine that no cone falls below
constexpr std::array kColonizationOwnKeys{
    ConfigurationKey{.name = "points",
                     .kind = KeyKind::Rows,
                     .description = "markers at given places x, y, z",
                     .unit = "length",
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "markerCount",
                     .kind = KeyKind::Integer,
                     .description = "number of random markers",
                     .minimum = 0.0,
                     .maximum = kMostMarkers},
    ConfigurationKey{.name = "markerBox",
                     .kind = KeyKind::Numbers,
                     .description = "box of the random markers: the corner with the smallest coordinates and the "
                                    "opposite one; only in the envelope when solids are given",
                     .unit = "length",
                     .defaultNumbers = kMarkerBox,
                     .minimumCount = 6,
                     .maximumCount = 6},
    ConfigurationKey{.name = "occupancyRadius",
                     .description = "distance up to which a bud or node takes the markers away",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "perceptionRadius",
                     .description = "distance up to which a bud perceives markers",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 4.0},
    ConfigurationKey{.name = "perceptionAngle",
                     .description = "full angle of the cone around the heading in which a bud perceives markers",
                     .unit = "degree",
                     .minimum = 0.0,
                     .maximum = 360.0,
                     .defaultNumber = 90.0},
};
constexpr auto kColonizationKeys = joinTables(kColonizationOwnKeys, kObstacleKeys);

class Colonization final : public turtle::EnvironmentProcess {
 public:
  Colonization(ObstacleScene envelope, const Configuration& configuration)
      : envelope_(std::move(envelope)),
        markerCount_(static_cast<std::size_t>(configuration.integer("markerCount"))),
        occupancyRadius_(configuration.number("occupancyRadius")),
        perceptionRadius_(configuration.number("perceptionRadius")),
        // half of the cone's angle; a full sphere has no cosine to fall below
        leastCosine_(configuration.number("perceptionAngle") >= 360.0
                         ? kEveryDirection
                         : core::cos(configuration.number("perceptionAngle") * 0.5 * 0.017453292519943295)) {
    for (const auto& row : configuration.rows("points")) {
      givenMarkers_.push_back({row[0], row[1], row[2]});
    }
    const auto& box = configuration.numbers("markerBox");
    box_ = {{box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "colonization",
            .summary = std::string(kColonizationSummary),
            .needs = {.position = true, .heading = true, .parameters = true},
            .inputs = {{"isBud", "1", ""}},
            .outputs = {{"spaceQuality", "1", ""},
                        {"directionX", "1", ""},
                        {"directionY", "1", ""},
                        {"directionZ", "1", ""},
                        {"markerCount", "1", ""}},
            .isStateful = true};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    std::vector<Vec3> markers = givenMarkers_;
    // points of the box that lie in the envelope, tried in order: a pure function of the seed
    const core::CounterRandom random(context.seed, 0);
    const auto tries = static_cast<std::uint64_t>(markerCount_) * kTriesPerMarker;
    const bool isEverywhere = envelope_.isEmpty();
    for (std::uint64_t i = 0; i < tries && markers.size() < givenMarkers_.size() + markerCount_; ++i) {
      if (i % 4096 == 0) {
        core::pollWork();
      }
      const auto between = [&](double low, double high, std::uint32_t draw) {
        return low + (high - low) * random.uniform(core::DrawDomain::Environment, 0, i, draw);
      };
      const Vec3 point{between(box_.low.x, box_.high.x, 0), between(box_.low.y, box_.high.y, 1),
                       between(box_.low.z, box_.high.z, 2)};
      if (isEverywhere || envelope_.isInside(point)) {
        markers.push_back(point);
      }
    }
    if (markers.size() < givenMarkers_.size() + markerCount_) {
      return turtle::EnvironmentError{
          "Environment 'colonization' finds hardly any place for its markers: less than a thousandth of 'markerBox' "
          "lies "
          "in the envelope. Put the box close around the solids.",
          false};
    }
    lengthUnit_ = context.world.lengthUnit;
    markers_ = std::move(markers);
    isFree_.assign(markers_.size(), 1);
    // sums over markers follow the order of these cells
    const SpatialCells cells(markers_, reach());
    ranks_.resize(markers_.size());
    std::uint32_t rank = 0;
    for (std::size_t cell = 0; cell < cells.cellCount(); ++cell) {
      for (const std::uint32_t marker : cells.pointsIn(cell)) {
        ranks_[marker] = rank++;
      }
    }
    free_ = gridOf(isFree_);
    // made here, so that most steps take no memory
    nearest_.resize(markers_.size());
    own_.reserve(markers_.size());
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (givenMarkers_.empty() && markerCount_ == 0 && queries.size() > 0) {
      return turtle::EnvironmentError{
          "Environment 'colonization' has no markers, so no bud would find space. Give 'points', or a 'markerCount' "
          "and "
          "the 'markerBox' to spread them in.",
          false};
    }
    if (isGivenUp_) {
      free_ = gridOf(isFree_);
      isGivenUp_ = false;
    }
    taken_.clear();
    try {
      occupy(queries.position);
      if (!taken_.empty()) {
        const std::uint8_t* const isFree = isFree_.data();
        free_.keep([isFree](const MarkerGrid::Marker& marker) { return isFree[marker.number] != 0; });
      }
      answerAll(queries, replies);
    } catch (...) {
      for (const std::uint32_t marker : taken_) {
        isFree_[marker] = 1;
      }
      isGivenUp_ = true;
      throw;
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    StateWriter writer;
    writer.integer(isFree_.size());
    for (std::size_t begin = 0; begin < isFree_.size(); begin += 64) {
      std::uint64_t word = 0;
      for (std::size_t i = begin; i < std::min(begin + 64, isFree_.size()); ++i) {
        word |= static_cast<std::uint64_t>(isFree_[i]) << (i - begin);
      }
      writer.integer(word);
    }
    return writer.take();
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    StateReader reader(state);
    std::vector<std::uint8_t> isFree;
    const bool isOfThisSize = reader.integer() == isFree_.size();
    while (isOfThisSize && isFree.size() < isFree_.size()) {
      const std::uint64_t word = reader.integer();
      const std::size_t left = std::min<std::size_t>(isFree_.size() - isFree.size(), 64);
      for (std::size_t i = 0; i < left; ++i) {
        isFree.push_back(static_cast<std::uint8_t>((word >> i) & 1U));
      }
    }
    if (!isOfThisSize || !reader.isComplete()) {
      return turtle::EnvironmentError{
          "The saved state of environment 'colonization' is damaged or of another number of markers. Use a snapshot "
          "that "
          "is complete and was made with this configuration.",
          false};
    }
    free_ = gridOf(isFree);
    isFree_ = std::move(isFree);
    isGivenUp_ = false;
    return std::nullopt;
  }

 private:
  [[nodiscard]] static bool isBud(const turtle::QueryBatch& queries, std::size_t query) {
    const auto parameters = queries.parametersOf(query);
    return !parameters.empty() && parameters[0] > 0.0;
  }

  [[nodiscard]] double reach() const { return std::max(occupancyRadius_, perceptionRadius_); }

  [[nodiscard]] MarkerGrid gridOf(const std::vector<std::uint8_t>& isFree) const {
    std::vector<MarkerGrid::Marker> markers;
    for (std::uint32_t i = 0; i < markers_.size(); ++i) {
      if (isFree[i] != 0) {
        markers.push_back({markers_[i], i, ranks_[i]});
      }
    }
    return {markers, reach()};
  }

  /// Takes the markers around places and notes them in `taken_`; `free_` still has them.
  void occupy(std::span<const Vec3> places) {
    for (const Vec3& place : places) {
      core::pollWork();
      const double radius = occupancyRadius_;
      visitWithin(place, boxOfCone(place, {}, radius, kEveryDirection), radius, [&](std::size_t slot, double) {
        const std::uint32_t marker = free_.markers()[slot].number;
        if (isFree_[marker] != 0) {
          taken_.push_back(marker);
          isFree_[marker] = 0;
        }
      });
    }
  }

  void answerAll(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) {
    // the distance of the nearest bud from each marker that is left
    std::fill_n(nearest_.begin(), free_.markers().size(), std::numeric_limits<double>::infinity());
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (isBud(queries, query)) {
        core::pollWork();
        visitPerceived(queries, query,
                       [&](std::size_t slot, double squared) { nearest_[slot] = std::min(nearest_[slot], squared); });
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      core::pollWork();
      answer(queries, query, replies);
    }
  }

  /// Calls `visit(slot, squared distance)` for the free markers of a box that lie within a radius.
  template <typename Visit>
  void visitWithin(const Vec3& place, const Bounds& box, double radius, const Visit& visit) const {
    free_.visitBox(box, [&](std::size_t slot) {
      const Vec3 offset = free_.markers()[slot].place - place;
      const double squared = core::dot(offset, offset);
      if (squared <= radius * radius) {
        visit(slot, squared);
      }
    });
  }

  /// The same for the free markers that a bud perceives.
  template <typename Visit>
  void visitPerceived(const turtle::QueryBatch& queries, std::size_t bud, const Visit& visit) const {
    const Vec3& place = queries.position[bud];
    const Vec3& heading = queries.heading[bud];
    const Bounds box = boxOfCone(place, heading, perceptionRadius_, leastCosine_);
    visitWithin(place, box, perceptionRadius_, [&](std::size_t slot, double squared) {
      if (core::dot(free_.markers()[slot].place - place, heading) >= leastCosine_ * std::sqrt(squared)) {
        visit(slot, squared);
      }
    });
  }

  void answer(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) {
    const std::size_t parameterCount = queries.parametersOf(query).size();
    if (parameterCount == 0) {
      return;
    }
    Vec3 sum;
    double own = 0.0;
    if (isBud(queries, query)) {
      // the markers to which no bud is nearer, in an order that does not depend on those that are gone
      own_.clear();
      visitPerceived(queries, query, [&](std::size_t slot, double squared) {
        if (squared == nearest_[slot]) {
          own_.emplace_back(free_.markers()[slot].rank, static_cast<std::uint32_t>(slot));
        }
      });
      std::sort(own_.begin(), own_.end());
      for (const auto& [rank, slot] : own_) {
        sum = sum + core::normalised(free_.markers()[slot].place - queries.position[query]);
        own += 1.0;
      }
    }
    // the sum of vectors that cancel is only rounding
    const Vec3 direction = core::length(sum) > 1e-9 * own ? core::normalised(sum) : Vec3{};
    const std::array<double, 5> values{own > 0.0 ? 1.0 : 0.0, direction.x, direction.y, direction.z, own};
    for (std::size_t k = 0; k < std::min(parameterCount, values.size()); ++k) {
      replies.set(queries, query, k, values[k]);
    }
  }

  ObstacleScene envelope_;
  std::vector<Vec3> givenMarkers_;
  Bounds box_;
  std::size_t markerCount_;  // random ones
  double occupancyRadius_;
  double perceptionRadius_;
  double leastCosine_;  // of the angle between heading and marker
  std::string lengthUnit_ = "m";
  std::vector<Vec3> markers_;
  std::vector<std::uint8_t> isFree_;  // (markers)
  std::vector<std::uint32_t> ranks_;  // place of each marker in sums (markers)
  MarkerGrid free_;                   // the markers that are left, unless a step was given up
  bool isGivenUp_ = false;            // whether the last step was
  // in a step
  std::vector<std::uint32_t> taken_;
  std::vector<double> nearest_;                               // squared distance of the nearest bud, by slot of free_
  std::vector<std::pair<std::uint32_t, std::uint32_t>> own_;  // rank and slot of the markers of one bud
};

ProcessOrErrors makeColonization(const Configuration& configuration) {
  auto read = readObstacles("colonization", configuration);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  const auto& box = configuration.numbers("markerBox");
  if (box[0] > box[3] || box[1] > box[4] || box[2] > box[5]) {
    return refuse("colonization", "'markerBox' has a first corner beyond the second",
                  "write the smallest x, y, z, then the largest x, y, z");
  }
  return std::make_unique<Colonization>(ObstacleScene(std::move(*read)), configuration);
}

}  // namespace

extern constinit const ProcessEntry kColonizationProcess{
    .name = "colonization",
    .summary = kColonizationSummary,
    .source =
        "Runions, Lane & Prusinkiewicz 2007, Modeling trees with a space colonization algorithm; Palubicki et al. "
        "2009, Self-organizing tree models for image synthesis",
    .keys = kColonizationKeys,
    .make = makeColonization};

}  // namespace espalier::environment
