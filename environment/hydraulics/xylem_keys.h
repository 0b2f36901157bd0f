#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "environment/base/process_entry.h"
#include "environment/hydraulics/conductivities.h"
#include "environment/hydraulics/plant_water.h"
#include "environment/hydraulics/root_uptake.h"
#include "environment/soil/ground.h"
#include "environment/soil/soil_body.h"

namespace espalier::environment {

inline constexpr std::string_view kXylemSummary =
    "Water in the xylem of the plants as they are drawn, from root tips to leaves, alone or with the water of the "
    "soil.";

/// Leaves with stomata, and the air around them when the weather does not say.
struct LeafKeys {
  bool hasStomata = false;
  Stomata stomata;
  bool isCurve = false;
  double width = 0.03;    // of a leaf, m
  double boundary = 0.0;  // conductance of the boundary layer, m/s; 0: by width and wind
  double temperature = 20.0;
  double humidity = 60.0;   // relative, %
  double wind = 1.0;        // m/s
  double pressure = 101.3;  // kPa
  double growthHead = -100.0;
  bool hasOwnStomataHead = false;
  bool hasOwnGrowthHead = false;

  /// Growth by turgor with a constant osmotic head (Lockhart 1965): 1 at the head 0, in proportion to 0 at growthHead.
  [[nodiscard]] double growthAt(double head) const { return std::clamp(1.0 - head / growthHead, 0.0, 1.0); }
};

/// The configuration of `xylem` as values. Nothing stands where a default of another length unit has to be converted.
struct XylemKeys {
  ConductivityTable radial;
  ConductivityTable axial;
  bool hasOwnAxial = false;
  double radius = 0.0;  // 0: as drawn
  double join = 0.0;
  double groundHeight = 0.0;
  std::vector<std::vector<double>> soilHeads;  // height, head; ascending
  double soilHead = -1.0;
  bool hasOwnSoilHead = false;
  bool hasCollarHead = false;  // else a flow
  double collarHead = -50.0;
  double lowestHead = -150.0;
  bool hasOwnLowestHead = false;
  bool hasOwnCollarHead = false;
  RateSeries transpiration;
  bool changesInTime = false;
  bool hasDayCourse = false;
  PlantWater::Leaves leaves;
  PlantWater::Vessels vessels;
  LeafKeys leafGas;
  bool hasRhizosphere = true;
  RootUptakeFromSoil::Limits limits;
};

[[nodiscard]] XylemKeys readXylem(const Configuration& configuration);

/// The errors of keys that have the right kind and range.
[[nodiscard]] std::vector<core::Diagnostic> checkXylem(const Configuration& configuration);

/// The soil of the key `soil`; nothing when there is none.
[[nodiscard]] tl::expected<std::optional<SoilBody>, std::vector<core::Diagnostic>> readXylemSoil(
    const Configuration& configuration);

/// The process of a configuration, or its errors.
[[nodiscard]] ProcessOrErrors makeXylem(const Configuration& configuration);

}  // namespace espalier::environment
