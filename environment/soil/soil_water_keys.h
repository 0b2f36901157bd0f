#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/length_unit.h"
#include "environment/base/process_entry.h"
#include "environment/soil/ground.h"
#include "environment/soil/solutes.h"

namespace espalier::environment {

inline constexpr std::string_view kSoilWaterSummary =
    "Water in unsaturated ground by Richards' equation, with solutes and acidity, and roots that take it up.";

/// The configuration of `soil-water` as values.
struct SoilWaterKeys {
  Ground::Shape shape;
  std::vector<SoilLayer> soils;     // from the top
  std::vector<double> thicknesses;  // of all layers but the last, length
  bool hasOwnLayers = false;        // layers were given
  std::vector<Solute> solutes;      // without H⁺
  bool acidity = false;
  double initialPh = 7.0;
  double rainPh = 5.6;
  double bufferCapacity = 0.0;
  double protonDiffusivity = 0.0;
  double dispersivity = 0.0;  // of H⁺
  SoilBorders borders;        // without the weather
  RateSeries rain;
  RateSeries evaporation;  // without evaporatesByWeather
  bool evaporatesByWeather = false;
  RateSeries groundLight;  // part of the global radiation that reaches the ground; without rows all
  double albedo = 0.0;
  double longWaveLoss = 0.0;   // W/m²
  double roughness = 0.0;      // m
  double windHeight = 2.0;     // m
  double airPressure = 101.3;  // kPa
  double initialHead = -1.0;
  std::vector<double> initialHeads;  // of the cells, x fastest; empty: none are given
  std::string fieldUnit;             // of them; empty: the world's unit of length
  std::optional<double> waterTableDepth;
  double wiltingHead = -150.0;
  bool hasSurfaceConcentration = false;  // the surface keeps the concentration of the rain
  RichardsSolver::Tolerance tolerances;

  /// Number of the layer at a depth below the top of the box.
  [[nodiscard]] int layerAt(double depth) const;
  /// H⁺ as a solute, when a volume of one length unit cubed holds so many litres.
  [[nodiscard]] Solute protons(double litres) const;
};

/// The values in the unit of a world; null: a unit of unknown size. Defaults are in metres and are converted.
[[nodiscard]] SoilWaterKeys readSoilWater(const Configuration& configuration, const LengthUnit* unit);

/// The errors of keys that have the right kind and range: rows that do not ascend, contents that contradict, a
/// field that is too large.
[[nodiscard]] std::vector<core::Diagnostic> checkSoilWater(const Configuration& configuration);

/// The process of a configuration, or its errors.
[[nodiscard]] ProcessOrErrors makeSoilWater(const Configuration& configuration);

}  // namespace espalier::environment
