#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace espalier::environment {

/// Water in the xylem of trees of segments, from the root tips to a collar or to leaves, in steady state. Within a
/// segment of radius a the head ψ follows ψ'' = c (ψ − ψs), c = 2πa kr/kx (Landsberg & Fowkes 1978), which is solved
/// exactly (Meunier et al., Applied Mathematical Modelling 52, 2017): the number of segments does not change the
/// result. Heads are pressure heads in a length, flows in length³ per day.
class HydraulicTree {
 public:
  static constexpr std::uint32_t kNoParent = 0xffffffff;

  /// A node, and the segment that joins it to its parent; a node without parent is a collar and has no segment.
  struct Node {
    std::uint32_t parent = kNoParent;  // an earlier node
    double length = 0.0;               // of the segment, above 0
    double rise = 0.0;                 // height of the node above its parent
    double radius = 0.0;
    double axialConductance = 0.0;    // kx, length³/day, above 0
    double radialConductivity = 0.0;  // kr, 1/day; 0: no water crosses the surface
    double soilHead = 0.0;            // at the surface of the segment, length
    double demand = 0.0;              // water that leaves the plant at this node (a leaf), length³/day
  };
  /// What holds at a collar: a head, or a flow out of the plant.
  struct Collar {
    bool hasHead = true;
    double head = 0.0;
    double flow = 0.0;
    double lowestHead = -1e300;  // with a flow: no lower than this, and the flow is less
  };

  /// Nodes in an order in which parents come first. `nodes` must outlive the tree or be given again.
  explicit HydraulicTree(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}

  [[nodiscard]] std::vector<Node>& nodes() { return nodes_; }
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  struct Result {
    std::vector<double> heads;            // at the nodes
    std::vector<double> uptakes;          // through the surface of each node's segment, into the plant
    std::vector<double> collarFlows;      // out of the plant at the collar of each tree, by collar (collars())
    std::vector<double> conductances;     // Krs: flow per difference of soil and collar heads, length²/day, by collar
    std::vector<double> uptakeFractions;  // SUF: parts of the uptake when the soil's total head is the same everywhere
  };
  /// Solves all trees; all collars have the same conditions. O(nodes).
  [[nodiscard]] Result solve(const Collar& collar) const;

  /// Indices of the nodes without parent, in order.
  [[nodiscard]] std::vector<std::uint32_t> collars() const;
  /// The collar that each node belongs to, as an index into collars().
  [[nodiscard]] std::vector<std::uint32_t> collarOf() const;

 private:
  std::vector<Node> nodes_;
};

}  // namespace espalier::environment
