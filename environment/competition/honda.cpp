// The process `honda` (docs/environments.md): collisions of branch tips with clusters of leaves of one radius.
//
// No state, independent of the order of queries. O(n log n) for n queries, for any crowding.

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <utility>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/plane.h"
#include "environment/geometry/spatial_cells.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kSummary =
    "Collision of tips of equal radius: a tip may grow unless another of its group with at least its vigor is near.";
constexpr std::array<std::string_view, 1> kAliases{"honda81"};
constexpr std::array<std::string_view, 1> kOn{"on"};
constexpr std::array kKeys{
    ConfigurationKey{.name = "radius",
                     .description = "distance up to which tips collide",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 0.0},
    kThreeDimensionalKey,
    kPlaneKey,
};
constexpr std::array kPublishedKeywords{
    PublishedKeyword{.keyword = "radius", .kind = PublishedKind::Number, .key = "radius"},
    PublishedKeyword{.keyword = "3d case", .kind = PublishedKind::Switch, .key = "threeDimensional", .onWords = kOn},
};

/// The values that a tip sends.
struct Tip {
  double vigor;
  double group;
};

class Honda final : public turtle::EnvironmentProcess {
 public:
  Honda(double radius, Plane plane) : radius_(radius), plane_(plane) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "honda",
            .summary = std::string(kSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"vigor", "1", ""}, {"group", "1", ""}},
            .outputs = {{"mayGrow", "1", ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    collect(queries);
    if (radius_ * radius_ > 0.0) {
      blockWithinRadius(queries, replies);
    } else {
      blockAtSamePoint(queries, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  void collect(const turtle::QueryBatch& queries) {
    positions_.resize(queries.size());
    tips_.resize(queries.size());
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      tips_[query].vigor = parameters.empty() ? 0.0 : parameters[0];
      tips_[query].group = parameters.size() < 2 ? 0.0 : parameters[1];
      positions_[query] = flattened(plane_, queries.position[query]);
    }
  }

  void blockWithinRadius(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) const {
    // the diagonal of a cell is just below the radius: members of a cell collide, so at most the strongest of each
    // group has to look around, and whatever is within the radius is at most two cells away in each direction
    const double diagonal = plane_ == Plane::Space ? 1.73205080756887719 : 1.41421356237309515;
    SpatialCells cells(positions_, radius_ / diagonal * (1.0 - 1e-9));
    sortMembers(cells);
    CellSweep sweep(cells, {plane_ == Plane::Yz ? 0 : 2, plane_ == Plane::Xz ? 0 : 2, plane_ == Plane::Xy ? 0 : 2});
    for (std::size_t cell = 0; cell < cells.cellCount(); ++cell) {
      for (const std::uint32_t tip : cells.pointsIn(cell)) {
        bool isBlocked = isBlockedBy(cells.pointsIn(cell), tip);
        if (!isBlocked) {
          sweep.moveTo(cell);
          isBlocked =
              sweep.anyNeighbour([&](std::size_t neighbour) { return isBlockedBy(cells.pointsIn(neighbour), tip); });
        }
        answer(queries, replies, tip, isBlocked);
      }
    }
  }

  /// Radius 0: tips sorted by group and point, the strongest first; in a run of equal points only a single strongest
  /// grows.
  void blockAtSamePoint(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) const {
    std::vector<std::uint32_t> order(queries.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (isSamePlace(a, b)) {
        return tips_[a].vigor > tips_[b].vigor;
      }
      return tips_[a].group != tips_[b].group ? tips_[a].group < tips_[b].group
                                              : lessPosition(positions_[a], positions_[b]);
    });
    for (std::size_t k = 0; k < order.size(); ++k) {
      const bool isBehind = k > 0 && isSamePlace(order[k - 1], order[k]);
      const bool isTied = k + 1 < order.size() && isSamePlace(order[k], order[k + 1]) &&
                          tips_[order[k]].vigor == tips_[order[k + 1]].vigor;
      answer(queries, replies, order[k], isBehind || isTied);
    }
  }

  [[nodiscard]] bool isSamePlace(std::uint32_t a, std::uint32_t b) const {
    return tips_[a].group == tips_[b].group && positions_[a] == positions_[b];
  }

  static void answer(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies, std::uint32_t tip,
                     bool isBlocked) {
    if (!queries.parametersOf(tip).empty()) {
      replies.set(queries, tip, 0, isBlocked ? 0.0 : 1.0);
    }
  }

  /// Members of a cell by group, then the strongest first: the tips that can block come first.
  void sortMembers(SpatialCells& cells) const {
    for (std::size_t cell = 0; cell < cells.cellCount(); ++cell) {
      const auto members = cells.members(cell);
      std::sort(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
        if (tips_[a].group != tips_[b].group) {
          return tips_[a].group < tips_[b].group;
        }
        return tips_[a].vigor > tips_[b].vigor;
      });
    }
  }

  static bool lessPosition(const Vec3& a, const Vec3& b) {
    if (a.x != b.x) {
      return a.x < b.x;
    }
    return a.y != b.y ? a.y < b.y : a.z < b.z;
  }

  [[nodiscard]] bool isBlockedBy(std::span<const std::uint32_t> members, std::uint32_t tip) const {
    const double group = tips_[tip].group;
    const auto first = std::partition_point(members.begin(), members.end(),
                                            [&](std::uint32_t other) { return tips_[other].group < group; });
    for (auto other = first; other != members.end(); ++other) {
      if (tips_[*other].group != group || tips_[*other].vigor < tips_[tip].vigor) {
        return false;
      }
      const Vec3 offset = positions_[*other] - positions_[tip];
      if (*other != tip && core::dot(offset, offset) <= radius_ * radius_) {
        return true;
      }
    }
    return false;
  }

  double radius_;
  Plane plane_;
  std::vector<Vec3> positions_;  // flattened (queries)
  std::vector<Tip> tips_;        // (queries)
};

}  // namespace

extern constinit const ProcessEntry kHondaProcess{
    .name = "honda",
    .summary = kSummary,
    .source =
        "Honda, Tomlinson & Fisher 1981, Computer simulation of branch interaction and regulation by unequal flow "
        "rates in botanical trees; Mech & Prusinkiewicz 1996",
    .aliases = kAliases,
    .keys = kKeys,
    .publishedKeywords = kPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Honda>(configuration.number("radius"), planeOf(configuration));
    }};

}  // namespace espalier::environment
