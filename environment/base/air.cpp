#include "environment/base/air.h"

#include <algorithm>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

// constants of Allen et al. 1998 (FAO-56): ratio of the molecular weights of water and air; gas constant of dry air,
// kJ kg⁻¹ K⁻¹, and the factor of a virtual temperature
constexpr double kWeightRatio = 0.622;
constexpr double kGasConstant = 0.287;
constexpr double kVirtual = 1.01;
constexpr double kZeroCelsius = 273.0;  // as equation 3-5 of FAO-56 has it
constexpr double kKarman = 0.41;
constexpr double kHeatRoughness = 0.1;  // roughness for heat and vapour over that for momentum

}  // namespace

double Air::deficit() const {
  return std::max(saturationPressure(temperature) - vapourPressure, 0.0);
}

double Air::density() const {
  return pressure / (kVirtual * kGasConstant * (temperature + kZeroCelsius));
}

double Air::psychrometric() const {
  return kAirHeat * pressure / (kWeightRatio * kLatentHeat);
}

double saturationPressure(double temperature) {
  return 0.6108 * core::exp(17.27 * temperature / (temperature + 237.3));
}

double saturationSlope(double temperature) {
  const double base = temperature + 237.3;
  return 17.27 * 237.3 * saturationPressure(temperature) / (base * base);
}

double airConductance(double wind, double height, double roughness) {
  return wind * kKarman * kKarman / (core::log(height / roughness) * core::log(height / (kHeatRoughness * roughness)));
}

double wetSurfaceEvaporation(const Air& air, double energy, double conductance) {
  const double slope = saturationSlope(air.temperature);
  const double drying = air.density() * kAirHeat * air.deficit() * conductance;
  return (slope * energy + drying) / (kLatentHeat * (slope + air.psychrometric()));
}

}  // namespace espalier::environment
