#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "environment/geometry/box_tree.h"
#include "environment/geometry/shapes.h"

namespace espalier::environment {

/// A segment with round ends that belongs to a plant.
struct PlantSegment {
  std::uint32_t plant = 0;
  Capsule capsule;
};

/// Segments of plants that only become more, found by place. New ones come into a tree of their own, and trees of about
/// one size are made one (Bentley & Saxe, Journal of Algorithms 1, 1980): adding k to n segments costs O(k log² n) in
/// the long run instead of O(n log n), and a search goes through O(log n) trees.
class SegmentTrees {
 public:
  void clear();
  void add(std::span<const PlantSegment> segments);
  /// All segments, in the order in which they were added.
  [[nodiscard]] const std::vector<PlantSegment>& segments() const { return segments_; }
  /// Whether a segment with round ends touches none of those of other plants.
  [[nodiscard]] bool isClear(std::uint32_t plant, const Capsule& segment) const;

 private:
  struct Part {
    std::size_t begin = 0;  // segments_[begin, end)
    std::size_t end = 0;
    BoxTree tree;
  };
  [[nodiscard]] BoxTree treeOf(std::size_t begin, std::size_t end) const;

  std::vector<PlantSegment> segments_;
  std::vector<Part> parts_;  // each more than twice as large as the next
};

}  // namespace espalier::environment
