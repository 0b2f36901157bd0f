#pragma once

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
