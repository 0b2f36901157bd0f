#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// A disc (or sphere) of influence with its rank in a contest: equal strengths have equal ranks, stronger ones higher.
struct Disc {
  core::Vec3 centre;
  double radius = 0.0;
  std::uint32_t rank = 0;
};

/// A tree over discs that finds an overlapping disc of at least some rank. Discs can be taken out. Building is
/// O(n log n), taking out O(log n); a search visits only boxes that reach the disc and hold a strong enough one, O(log
/// n) for discs that do not crowd around each other's borders.
class DiscTree {
 public:
  explicit DiscTree(std::vector<Disc> discs);

  /// Whether another disc still in the tree with rank >= `rank` overlaps disc `index`: the distance of the centres is
  /// at most the sum of the radii.
  [[nodiscard]] bool isOverlapped(std::size_t index, std::uint32_t rank) const;
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
  std::vector<std::uint32_t> leafOf_;    // node by disc
  std::vector<Node> nodes_;              // the root first
};

}  // namespace espalier::environment
