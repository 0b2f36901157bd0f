#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
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
    double demand = 0.0;              // water that leaves the plant at this node (a leaf) at head 0, length³/day
    double demandByHead = 0.0;        // how much more at a higher head, length²/day, at least 0
    std::uint32_t plant = 0;          // of a collar: the collars of a plant have one head
  };
  /// What holds at the collars of a plant: a head, or a flow out of all its collars together.
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
    std::vector<double> collarFlows;      // out of all collars of a plant (plants)
    std::vector<double> conductances;     // Krs: flow per difference of soil and collar heads, length²/day (plants)
    std::vector<double> uptakeFractions;  // SUF: parts of the uptake when the soil's total head is the same everywhere
  };
  /// Solves all trees. `plants` has the conditions of each plant, or of all when there is one. O(nodes).
  [[nodiscard]] Result solve(std::span<const Collar> plants) const;
  [[nodiscard]] Result solve(const Collar& all) const { return solve(std::span(&all, 1)); }

  /// The plant of each node.
  [[nodiscard]] std::vector<std::uint32_t> plantOf() const;

 private:
  /// The head of each plant's collars, from the flows out of the nodes below as base + slope · head (nodes).
  [[nodiscard]] std::vector<double> collarHeads(std::span<const Collar> plants, const std::vector<double>& base,
                                                const std::vector<double>& slope) const;

  std::vector<Node> nodes_;
};

}  // namespace espalier::environment
