#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "environment/hydraulics/plant_water.h"
#include "environment/soil/soil_body.h"

namespace espalier::environment {

/// Sums over time of what plants do, for means.
struct WaterSums {
  double days = 0.0;
  std::vector<double> heads, uptakes, surfaceHeads, given;  // (nodes)
  std::vector<double> collarHeads, collarFlows;             // (plants)
  std::vector<PlantWater::LeafState> leaves;                // (nodes), or empty

  void add(const PlantWater::Result& result, const std::vector<HydraulicTree::Node>& nodes, double days);
};

/// Roots that draw water from a soil while time passes. In each internal step the uptake belongs to the heads at its
/// end. Newton's method solves soil and plants together, so what the plants take is what leaves the cells.
class RootUptakeFromSoil final : public RichardsSolver::Uptake {
 public:
  /// `middles` are those of the nodes' segments, `axes` the world axes along which they run most (nodes). Both
  /// references must outlive the object.
  RootUptakeFromSoil(PlantWater& plants, SoilBody& soil, const std::vector<core::Vec3>& middles,
                     const std::vector<std::uint8_t>& axes, bool hasRhizosphere);

  struct Limits {
    double longestStep = 1.0 / 48.0;  // days
    double tolerance = 1e-6;          // of the water content of a cell in an internal step
  };
  using CollarsBetween = std::function<std::vector<HydraulicTree::Collar>(double from, double until)>;
  /// Lets `days` pass. The error says what did not converge, as the end of a sentence; the soil then is not as before.
  [[nodiscard]] std::optional<std::string> passTime(double days, const Limits& limits, const CollarsBetween& collars,
                                                    WaterSums& sums);

  [[nodiscard]] bool takeAt(const std::vector<double>& heads, double days, std::vector<double>& sinks,
                            std::vector<double>& byHead) override;
  void addChange(const std::vector<double>& headChanges, std::vector<double>& sinkChanges) const override;

 private:
  /// A part of what a segment takes up, and the cell that gives it.
  struct Share {
    std::size_t cell = 0;
    double part = 1.0;
    double above = 0.0;  // height of the cell's middle above that of the segment, length
  };
  [[nodiscard]] std::span<const Share> sharesOf(std::size_t node) const {
    return std::span(shares_).subspan(firstShare_[node], firstShare_[node + 1] - firstShare_[node]);
  }
  void addShares(std::size_t cell, std::size_t reach, const core::Vec3& middle, std::uint8_t axis);

  PlantWater* plants_;
  SoilBody* soil_;
  std::vector<Share> shares_;
  std::vector<std::size_t> firstShare_;  // of each node's segment, none outside the soil (nodes + 1)
  CollarsBetween collars_;
  PlantWater::Result last_;  // of takeAt()
  double plantError_ = 0.0;  // part of the flow that was wrong when the last takeAt() failed, or 0
};

}  // namespace espalier::environment
