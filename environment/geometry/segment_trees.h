#pragma once

#include <cstdint>
#include <optional>
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

/// Segments of plants, found by place; segments are added and never removed. New segments get their own tree, and trees
/// of about the same size are merged (Bentley & Saxe, Journal of Algorithms 1, 1980). Adding k to n segments costs
/// amortised O(k log² n) instead of O(n log n), and a search visits O(log n) trees.
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
    std::optional<std::uint32_t> plant;  // that all of them belong to
    BoxTree tree;
  };
  [[nodiscard]] BoxTree treeOf(std::size_t begin, std::size_t end) const;
  [[nodiscard]] std::optional<std::uint32_t> plantOf(std::size_t begin, std::size_t end) const;

  std::vector<PlantSegment> segments_;
  std::vector<Part> parts_;  // each more than twice as large as the next
};

}  // namespace espalier::environment
