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
  /// The condition at the collars of a plant: a head, or a flow out of all its collars together.
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

  /// The flows of a node and its segment, as a linear function of the heads at the upper end (towards the collar) and
  /// the lower end. The flow towards the collar is through·(lower − upper) + half·lower − supply + gravity at the lower
  /// end, and through·(lower − upper) − half·upper + supply + gravity at the upper end.
  struct Segment {
    double through = 0.0;       // length²/day, at least 0
    double half = 0.0;          // half of what enters less at a higher head of both ends, length²/day, at least 0
    double supply = 0.0;        // half of what enters at head 0, length³/day
    double gravity = 0.0;       // length³/day
    double demand = 0.0;        // as that of the node
    double demandByHead = 0.0;  // as that of the node
  };
  /// The segment of a node, exactly.
  [[nodiscard]] static Segment segmentOf(const Node& node);
  /// The segments of all nodes.
  [[nodiscard]] std::vector<Segment> segments() const;

  struct Result {
    std::vector<double> heads;              // at the nodes
    std::vector<double> uptakes;            // through the surface of each node's segment, into the plant
    std::vector<double> collarFlows;        // out of all collars of a plant (plants)
    std::vector<std::uint8_t> isFlowGiven;  // whether the flow, not the head, holds at the collars (plants)
    std::vector<double> conductances;       // Krs: flow per difference of soil and collar heads, length²/day (plants)
    std::vector<double> uptakeFractions;  // SUF: parts of the uptake when the soil's total head is the same everywhere
  };
  /// Solves all trees. `plants` has the conditions of each plant, or of all when there is one. O(nodes).
  [[nodiscard]] Result solve(std::span<const Collar> plants) const;
  [[nodiscard]] Result solve(const Collar& all) const { return solve(std::span(&all, 1)); }
  /// The same with other segments, without conductances and fractions.
  [[nodiscard]] Result solve(std::span<const Collar> plants, const std::vector<Segment>& segments) const;
  /// How the uptakes change when the supplies of the segments change, near a solution. O(nodes).
  [[nodiscard]] std::vector<double> changeOf(const Result& solution, const std::vector<Segment>& segments,
                                             const std::vector<double>& supplyChanges) const;

  /// The plant of each node.
  [[nodiscard]] std::vector<std::uint32_t> plantOf() const;

 private:
  /// The coefficients of each node after elimination from the tips to the collars (nodes).
  struct Elimination {
    std::vector<double> pivot;
    std::vector<double> slope;  // how the flow into a node from below grows with its head
  };
  [[nodiscard]] Elimination eliminate(const std::vector<Segment>& segments) const;
  [[nodiscard]] Result solve(std::span<const Collar> plants, const std::vector<Segment>& segments,
                             const Elimination& elimination) const;
  /// Adds up a quantity of the collars of each plant.
  [[nodiscard]] std::vector<double> sumOfCollars(const std::vector<double>& values) const;
  void addConductances(const std::vector<Segment>& segments, const Elimination& elimination, Result& result) const;

  std::vector<Node> nodes_;
};

}  // namespace espalier::environment
