#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/geometry/interval.h"

namespace espalier::environment {

/// A disc (or sphere) of influence with its rank in a contest: equal strengths have equal ranks, stronger ones higher.
struct Disc {
  core::Vec3 centre;
  double radius = 0.0;
  std::uint32_t rank = 0;
};

/// Whether two discs overlap: the distance of the centres is at most the sum of the radii.
[[nodiscard]] inline bool discsOverlap(const Disc& a, const Disc& b) {
  const core::Vec3 offset = b.centre - a.centre;
  const double sum = a.radius + b.radius;
  return sum >= 0.0 && core::dot(offset, offset) <= sum * sum;
}

/// A tree over discs that finds an overlapping disc of at least some rank. Discs can be taken out. Building is
/// O(n log n), taking out O(log n); a search visits only boxes that reach the disc and hold a strong enough one, O(log
/// n) for discs that do not crowd around each other's borders.
class DiscTree {
 public:
  explicit DiscTree(std::vector<Disc> discs);

  /// Whether another disc still in the tree with rank >= `rank` overlaps disc `index`. `overlaps(own, other)` decides
  /// for two discs; it may differ from discsOverlap by a rounding error of 32-bit floats.
  template <typename Overlaps>
  [[nodiscard]] bool isOverlapped(std::size_t index, std::uint32_t rank, const Overlaps& overlaps) const;
  /// All discs, neighbours near each other: searching in this order reads memory in order.
  [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }
  /// Takes a disc out: it is no longer found.
  void remove(std::size_t index);

 private:
  struct Node {
    core::Vec3 low, high;           // box of the centres
    double maximumRadius = 0.0;     // of the discs in the tree
    std::int64_t maximumRank = -1;  // of those; -1: all are taken out
    std::uint32_t begin = 0;        // discs order_[begin, end)
    std::uint32_t end = 0;
    std::uint32_t children = 0;  // the first of two neighbours; 0: a leaf
    std::uint32_t parent = 0;
  };

  void build(std::uint32_t node);
  void update(Node& node) const;

  static constexpr std::uint32_t kLeafSize = 8;

  std::vector<Disc> discs_;
  std::vector<std::uint8_t> isRemoved_;  // by disc
  std::vector<std::uint32_t> order_;     // discs grouped by leaf
  std::vector<Disc> grouped_;            // as order_
  std::vector<std::uint32_t> leafOf_;    // node by disc
  std::vector<Node> nodes_;              // the root first
};

template <typename Overlaps>
bool DiscTree::isOverlapped(std::size_t index, std::uint32_t rank, const Overlaps& overlaps) const {
  constexpr double kMargin = 1.0 + 1e-5;  // more than floats round
  const Disc& own = discs_[index];
  // halving keeps the tree flat: a stack of this size is enough for 2^32 discs
  std::array<std::uint32_t, 64> open;
  std::size_t depth = 0;
  open[depth++] = 0;
  while (depth > 0) {
    const Node& node = nodes_[open[--depth]];
    const double reach = (own.radius + node.maximumRadius) * kMargin;
    const core::Vec3 gap{outside(own.centre.x, node.low.x, node.high.x), outside(own.centre.y, node.low.y, node.high.y),
                         outside(own.centre.z, node.low.z, node.high.z)};
    if (node.maximumRank < static_cast<std::int64_t>(rank) || reach < 0.0 || core::dot(gap, gap) > reach * reach) {
      continue;
    }
    if (node.children != 0) {
      open[depth++] = node.children;
      open[depth++] = node.children + 1;
      continue;
    }
    for (std::uint32_t k = node.begin; k < node.end; ++k) {
      const Disc& other = grouped_[k];
      if (other.rank >= rank && order_[k] != index && isRemoved_[order_[k]] == 0 && overlaps(own, other)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace espalier::environment
