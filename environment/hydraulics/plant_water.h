#pragma once

#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "environment/hydraulics/hydraulic_tree.h"
#include "environment/soil/flux_potential.h"

namespace espalier::environment {

/// Water in plants whose flow does not only grow in proportion to heads: soil that resists around roots, leaves that
/// close, vessels that fill with air.
class PlantWater {
 public:
  /// The soil around the segment of a node.
  struct Soil {
    const FluxPotential* potential = nullptr;  // null: the soil does not resist
    double factor = 0.0;                       // g (rhizosphere.h)
  };
  /// Leaves give what is wanted above `open`, nothing below `closed`, and in between in proportion.
  struct Leaves {
    bool canClose = false;
    double open = 0.0;
    double closed = -1.0;
  };
  /// kx is multiplied by 1/(1 + (ψ/half)^shape) (Manzoni et al., New Phytologist 198, 2013); half = 0: by 1.
  struct Vessels {
    double half = 0.0;
    double shape = 1.0;
  };

  PlantWater(HydraulicTree tree, const Leaves& leaves, const Vessels& vessels);

  /// The tree with kr of the roots alone and with kx of full vessels. Its soil heads and demands may change.
  [[nodiscard]] std::vector<HydraulicTree::Node>& nodes() { return tree_.nodes(); }
  [[nodiscard]] const std::vector<HydraulicTree::Node>& nodes() const { return tree_.nodes(); }
  [[nodiscard]] const HydraulicTree& tree() const { return tree_; }
  [[nodiscard]] std::vector<Soil>& soils() { return soils_; }
  [[nodiscard]] const std::vector<Soil>& soils() const { return soils_; }

  struct Result {
    HydraulicTree::Result flow;
    std::vector<double> surfaceHeads;  // at the surface of each node's segment; of a segment without soil 0
    std::vector<double> given;         // what each leaf gives, length³/day (nodes)
    int rounds = 1;
  };
  /// Solves by Newton's method; uptake is a concave function of the head, so it converges from any start. Leaves go
  /// from part to part of their curve: all at once, and later one a round (Murty, Linear Algebra and its Applications
  /// 9, 1974). The error is the part of the flow that is still wrong after the last round.
  [[nodiscard]] tl::expected<Result, double> solve(std::span<const HydraulicTree::Collar> plants);

 private:
  [[nodiscard]] double openness(double head) const;
  [[nodiscard]] double vesselPart(double head) const;
  [[nodiscard]] double updateSoil(std::size_t node, Result& result);
  [[nodiscard]] double updateLeaf(std::size_t node, Result& result, bool& maySwitch);
  [[nodiscard]] double updateVessels(std::size_t node, const Result& result);

  /// The part of its curve on which a leaf is taken to be.
  enum class LeafPart : std::uint8_t { Closing, Open, Closed };

  HydraulicTree tree_;
  HydraulicTree linear_;  // the tree of a round of Newton's method
  Leaves leaves_;
  Vessels vessels_;
  std::vector<Soil> soils_;           // (nodes)
  std::vector<double> surfaceHeads_;  // of the last round (nodes)
  std::vector<LeafPart> leafParts_;   // (nodes)
};

}  // namespace espalier::environment
