#pragma once

#include <cstdint>
#include <span>
#include <tl/expected.hpp>
#include <vector>

#include "environment/hydraulics/hydraulic_tree.h"
#include "environment/hydraulics/leaf_gas.h"
#include "environment/hydraulics/rhizosphere.h"
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

  /// A leaf at a node whose stomata follow light, air and the head of its water.
  struct GasLeaf {
    double flow = 0.0;          // length³/day of water for each kg m⁻² s⁻¹; 0: there is no leaf
    double netRadiation = 0.0;  // W/m²
    double boundary = 0.0;      // conductance of the boundary layer, m/s
    double open = 0.0;          // conductance of the stomata without the part by head, m/s
    Air air;
  };
  /// The state of a leaf of this kind.
  struct LeafState {
    double conductance = 0.0;  // of stomata and cuticle, m/s
    double temperature = 0.0;  // degrees Celsius
    double waterPart = 0.0;    // f(ψ)
    double latent = 0.0;       // W/m²
  };

  PlantWater(HydraulicTree tree, const Leaves& leaves, const Vessels& vessels);

  /// Adds leaves with stomata. `isCurve` as in leafExchange().
  void setStomata(const Stomata& stomata, bool isCurve);
  /// Those leaves (nodes; empty without setStomata).
  [[nodiscard]] std::vector<GasLeaf>& gasLeaves() { return gasLeaves_; }

  /// The tree with kr of the roots alone and with kx of full vessels. Its soil heads and demands may change.
  [[nodiscard]] std::vector<HydraulicTree::Node>& nodes() { return tree_.nodes(); }
  [[nodiscard]] const std::vector<HydraulicTree::Node>& nodes() const { return tree_.nodes(); }
  [[nodiscard]] const HydraulicTree& tree() const { return tree_; }
  [[nodiscard]] std::vector<Soil>& soils() { return soils_; }
  [[nodiscard]] const std::vector<Soil>& soils() const { return soils_; }

  struct Result {
    HydraulicTree::Result flow;
    std::vector<double> surfaceHeads;  // at the surface of each node's segment; of a segment without soil 0
    std::vector<double> given;         // the water that each leaf gives, length³/day (nodes)
    std::vector<LeafState> leaves;     // with stomata (nodes), or empty
    int rounds = 1;
  };
  /// Solves by Newton's method; uptake is a concave function of the head, so it converges from any start. Leaves go
  /// from part to part of their curve: all at once, and later one a round (Murty, Linear Algebra and its Applications
  /// 9, 1974). With stomata, whose response is neither concave nor convex, a round goes as much of the way as makes the
  /// error smaller. The error is the part of the flow that is still wrong after the last round.
  [[nodiscard]] tl::expected<Result, double> solve(std::span<const HydraulicTree::Collar> plants);

  /// How much more each segment would take up at a higher head of its soil if heads in the xylem stayed, in the last
  /// solution, length²/day (nodes).
  [[nodiscard]] const std::vector<double>& bySoilHead() const { return bySoilHead_; }
  /// How uptakes change with the heads of the soil near the last solution, when heads in the xylem follow. O(nodes).
  [[nodiscard]] std::vector<double> changeOf(const Result& solution, const std::vector<double>& soilHeadChanges) const;

 private:
  /// The error that a round of Newton's method found, length³/day.
  struct Wrong {
    double flow = 0.0;
    double rounding = 0.0;  // from the rounding of heads alone
    double vessels = 0.0;   // part of kx
  };
  /// The errors of each node's exchange with the soil and of its leaf, length³/day (nodes).
  struct Residuals {
    std::vector<double> soil, leaf;
  };
  [[nodiscard]] bool resists(std::size_t node) const {
    return soils_[node].potential != nullptr && soils_[node].factor > 0.0;
  }
  [[nodiscard]] double openness(double head) const;
  [[nodiscard]] double vesselPart(double head) const;
  void begin();
  [[nodiscard]] Wrong update(Result& result);
  [[nodiscard]] double residualsAt(const std::vector<double>& heads, double share, Residuals& residuals) const;
  [[nodiscard]] double goTowards(std::vector<double>& heads, double before, bool isFirst);
  [[nodiscard]] double updateSoil(std::size_t node, Result& result);
  [[nodiscard]] double updateLeaf(std::size_t node, Result& result, bool& maySwitch);
  [[nodiscard]] double updateGasLeaf(std::size_t node, Result& result);
  [[nodiscard]] LeafExchange exchangeAt(const GasLeaf& leaf, double head) const;
  [[nodiscard]] double updateVessels(std::size_t node, const Result& result);

  /// The part of its curve on which a leaf is taken to be.
  enum class LeafPart : std::uint8_t { Closing, Open, Closed };

  HydraulicTree tree_;
  Leaves leaves_;
  Vessels vessels_;
  std::vector<Soil> soils_;                        // (nodes)
  std::vector<SoilPoint> soilPoints_;              // of the present soil (nodes)
  std::vector<double> axialConductances_;          // with what vessels have lost (nodes)
  std::vector<HydraulicTree::Segment> roots_;      // without resistance of the soil (nodes)
  std::vector<HydraulicTree::Segment> segments_;   // of a round of Newton's method (nodes)
  std::vector<double> surfaceHeads_, bySoilHead_;  // of the last round (nodes)
  std::vector<LeafPart> leafParts_;                // (nodes)
  Stomata stomata_;
  bool isCurve_ = false;
  std::vector<GasLeaf> gasLeaves_;  // (nodes), or empty
  std::vector<double> point_;       // heads where segments_ are linear (nodes)
  Residuals residuals_;             // there
};

}  // namespace espalier::environment
