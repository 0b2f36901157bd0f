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
    core::Vec3 start;  // of the segment as drawn: within `join` of the parent's place
    std::uint32_t plant = 0;
    std::uint64_t module = 0;  // index of the module that drew the segment; of a collar 0
    std::uint32_t order = 1;   // of the branch as drawn, from 1
    double radius = 0.0;       // half the width at the end, which the model set for the segment
  };

  /// `join` is the distance within which a start meets a point; 0: the same numbers.
  explicit PlantTrees(double join = 0.0) : join_(join) {}

  /// Joins the segments of a step. A plant that draws what it drew in the call before keeps its trees. Segments without
  /// length are left out. Expected O(segments) when few points lie within `join` of each other.
  void update(const turtle::Geometry& geometry);

  /// The nodes of all plants; the nodes of one plant follow one another.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  /// The last node at a place that a plant has drawn up to a module; nothing when there is none. A collar is found from
  /// any module.
  [[nodiscard]] std::optional<std::uint32_t> nodeAt(std::uint32_t plant, std::uint64_t module,
                                                    const core::Vec3& place) const;
  /// How many plants kept their trees in the last call of update().
  [[nodiscard]] std::size_t keptPlants() const { return keptPlants_; }

 private:
  /// The nodes of one plant: a range of `nodes_`, found by their places. Indices count from its first node.
  struct Plant {
    std::uint32_t first = 0, end = 0;
    std::unordered_map<std::uint64_t, std::uint32_t> last;  // the last node of each key
    std::vector<std::uint32_t> before;                      // the node of the same key before each node, or kNone
  };

  [[nodiscard]] bool isKept(const turtle::Geometry& geometry, std::size_t first, std::size_t end,
                            const Plant& before) const;
  void join(const turtle::Geometry& geometry, std::size_t first, std::size_t end, Plant& plant);
  [[nodiscard]] std::uint64_t keyOf(const core::Vec3& place, int dx, int dy, int dz) const;
  [[nodiscard]] std::uint32_t find(const Plant& plant, std::uint64_t module, const core::Vec3& place) const;
  void add(const Node& node, Plant& plant);

  double join_;
  std::vector<Node> nodes_, nodesBefore_;            // of this step and of the one before
  std::unordered_map<std::uint32_t, Plant> plants_;  // by their number
  std::size_t keptPlants_ = 0;
};

}  // namespace espalier::environment
