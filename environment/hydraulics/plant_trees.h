#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/scene/geometry.h"

namespace espalier::environment {

/// The segments that all plants draw, joined to trees. A segment grows from the last point, drawn before it by the same
/// plant, that lies where it starts. A segment that starts elsewhere begins at a collar.
class PlantTrees {
 public:
  static constexpr std::uint32_t kNone = 0xffffffff;

  /// A point of a plant, and the segment from its parent to it. A collar has no parent and no segment.
  struct Node {
    std::uint32_t parent = kNone;  // an earlier node
    core::Vec3 place;
    std::uint32_t plant = 0;
    std::uint64_t module = 0;  // index of the module that drew the segment; of a collar 0
    std::uint32_t order = 1;   // of the branch as drawn, from 1
    double radius = 0.0;       // half the width at the end, which the model set for the segment
  };

  /// `join` is the distance within which a start meets a point; 0: the same numbers. Segments without length are left
  /// out. Expected O(segments) when few points lie within `join` of each other.
  PlantTrees(const turtle::Geometry& geometry, double join);

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  /// The last node at a place that a plant has drawn up to a module; nothing when there is none. A collar is found from
  /// any module.
  [[nodiscard]] std::optional<std::uint32_t> nodeAt(std::uint32_t plant, std::uint64_t module,
                                                    const core::Vec3& place) const;

 private:
  [[nodiscard]] std::uint64_t keyOf(std::uint32_t plant, const core::Vec3& place, int dx, int dy, int dz) const;
  [[nodiscard]] std::uint32_t find(std::uint32_t plant, std::uint64_t module, const core::Vec3& place) const;
  void add(const Node& node);

  double join_;
  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, std::uint32_t> last_;  // the last node of each key
  std::vector<std::uint32_t> before_;                      // the node of the same key before each node, or kNone
};

}  // namespace espalier::environment
