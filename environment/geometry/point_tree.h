#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A tree of points that finds the nearest one: boxes are halved along their longest side. The result does not depend
/// on the halving. Building is O(n log n); a search is O(log n), also when points crowd or lie at the same place.
class PointTree {
 public:
  /// `points` must outlive the tree.
  explicit PointTree(std::span<const core::Vec3> points);

  /// The nearest of the other points whose squared distance is at most `most`; of equally near ones that with the
  /// smallest index. Nothing when there is none.
  [[nodiscard]] std::optional<std::uint32_t> nearestOther(std::uint32_t point, double most) const;
  /// All points, neighbours near each other: searching in this order reads memory in order.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

 private:
  struct Node {
    core::Vec3 low, high;     // box of the points
    std::uint32_t begin = 0;  // points order_[begin, end)
    std::uint32_t end = 0;
    std::uint32_t first = 0;     // the smallest index of its points
    std::uint32_t children = 0;  // the first of two neighbours; 0: a leaf
  };

  void build(std::uint32_t node);

  static constexpr std::uint32_t kLeafSize = 8;

  std::span<const core::Vec3> points_;
  std::vector<std::uint32_t> order_;  // point indices grouped by leaf
  std::vector<Node> nodes_;           // the root first
};

}  // namespace espalier::environment
