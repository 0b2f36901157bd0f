#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "engine/turtle/environment_process.h"
#include "environment/geometry/plane.h"
#include "environment/geometry/spatial_cells.h"

namespace espalier::environment {

/// A branch tip and the values that it sends.
struct Tip {
  core::Vec3 position;  // flattened
  double vigor = 0.0;
  double group = 0.0;
};

/// The tip of a query.
[[nodiscard]] inline Tip tipOf(const turtle::QueryBatch& queries, std::size_t query, Plane plane) {
  const auto parameters = queries.parametersOf(query);
  return {flattened(plane, queries.position[query]), parameters.empty() ? 0.0 : parameters[0],
          parameters.size() < 2 ? 0.0 : parameters[1]};
}

/// Finds the tips that are blocked: another tip of the same group with at least the vigor is near. O(n log n) for any
/// crowding, because members of a cell are near each other, so only the strongest of a cell and group look around.
class TipCollisions {
 public:
  /// `tips` must outlive the object. With the radius 0 only tips at one point are near.
  TipCollisions(std::span<const Tip> tips, double radius, Plane plane) : tips_(tips), radius_(radius), plane_(plane) {}

  /// Calls `answer(tip, isBlocked)` for every tip. `isNear(a, b)` decides for two different tips; it may differ from
  /// the distance `radius` by a rounding error.
  template <typename IsNear, typename Answer>
  void settle(const IsNear& isNear, const Answer& answer) const {
    if (!(radius_ * radius_ > 0.0)) {
      settleAtSamePoint(answer);
      return;
    }
    // the diagonal of a cell is just below the radius, so everything within it is at most two cells away each way
    const double diagonal = plane_ == Plane::Space ? 1.73205080756887719 : 1.41421356237309515;
    std::vector<core::Vec3> positions;
    positions.reserve(tips_.size());
    for (const Tip& tip : tips_) {
      positions.push_back(tip.position);
    }
    SpatialCells cells(positions, radius_ / diagonal * (1.0 - 1e-9));
    sortMembers(cells);
    CellSweep sweep(cells, {plane_ == Plane::Yz ? 0 : 2, plane_ == Plane::Xz ? 0 : 2, plane_ == Plane::Xy ? 0 : 2});
    for (std::size_t cell = 0; cell < cells.cellCount(); ++cell) {
      for (const std::uint32_t tip : cells.pointsIn(cell)) {
        bool isBlocked = isBlockedBy(cells.pointsIn(cell), tip, isNear);
        if (!isBlocked) {
          sweep.moveTo(cell);
          isBlocked = sweep.anyNeighbour(
              [&](std::size_t neighbour) { return isBlockedBy(cells.pointsIn(neighbour), tip, isNear); });
        }
        answer(std::size_t{tip}, isBlocked);
      }
    }
  }

 private:
  /// Tips sorted by group and point, the strongest first; in a run of equal points only a single strongest is free.
  template <typename Answer>
  void settleAtSamePoint(const Answer& answer) const {
    const std::vector<std::uint32_t> order = orderByPlace();
    for (std::size_t k = 0; k < order.size(); ++k) {
      const bool isBehind = k > 0 && isSamePlace(order[k - 1], order[k]);
      const bool isTied = k + 1 < order.size() && isSamePlace(order[k], order[k + 1]) &&
                          tips_[order[k]].vigor == tips_[order[k + 1]].vigor;
      answer(std::size_t{order[k]}, isBehind || isTied);
    }
  }

  template <typename IsNear>
  [[nodiscard]] bool isBlockedBy(std::span<const std::uint32_t> members, std::uint32_t tip,
                                 const IsNear& isNear) const {
    const Tip& own = tips_[tip];
    const auto first = std::partition_point(members.begin(), members.end(),
                                            [&](std::uint32_t other) { return tips_[other].group < own.group; });
    for (auto other = first; other != members.end(); ++other) {
      if (tips_[*other].group != own.group || tips_[*other].vigor < own.vigor) {
        return false;
      }
      if (*other != tip && isNear(own, tips_[*other])) {
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] bool isSamePlace(std::uint32_t a, std::uint32_t b) const;
  [[nodiscard]] std::vector<std::uint32_t> orderByPlace() const;
  void sortMembers(SpatialCells& cells) const;

  std::span<const Tip> tips_;
  double radius_;
  Plane plane_;
};

}  // namespace espalier::environment
