#pragma once

#include <cstdint>
#include <functional>
#include <optional>
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
  /// `middles` are those of the nodes' segments (nodes). Both references must outlive the object.
  RootUptakeFromSoil(PlantWater& plants, SoilBody& soil, const std::vector<core::Vec3>& middles, bool hasRhizosphere);

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
  PlantWater* plants_;
  SoilBody* soil_;
  std::vector<std::int64_t> cellOf_;  // of each node's segment, −1: not in soil (nodes)
  std::vector<double> above_;         // height of a cell's middle above that of the segment, length (nodes)
  CollarsBetween collars_;
  PlantWater::Result last_;  // of takeAt()
  double plantError_ = 0.0;  // part of the flow that was wrong when the last takeAt() failed, or 0
};

}  // namespace espalier::environment
