#include "environment/hydraulics/leaf_gas.h"

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::environment {

LeafExchange leafExchange(const Air& air, double netRadiation, double boundaryConductance, double stomatalConductance,
                          bool isCurve) {
  const double density = air.density();
  const double psychrometric = air.psychrometric();
  const double heat = density * kAirHeat * boundaryConductance;  // sensible heat, W m⁻² K⁻¹
  const double both = boundaryConductance + stomatalConductance;
  const double path = both > 0.0 ? boundaryConductance * stomatalConductance / both : 0.0;  // of vapour, m/s
  const double perPressure = density * kAirHeat / psychrometric;  // latent heat per conductance and kPa, J m⁻³ kPa⁻¹
  const double airDeficit = saturationPressure(air.temperature) - air.vapourPressure;
  LeafExchange result;
  // the temperature of the leaf above that of the air; on the tangent one round is exact
  double above = 0.0;
  double slope = saturationSlope(air.temperature);
  double deficit = airDeficit;  // of the air against the inside of the leaf
  for (int round = 0; round < 100; ++round) {
    const double rest = netRadiation - heat * above - perPressure * path * deficit;
    const double grows = heat + perPressure * path * slope;
    const double change = grows > 0.0 ? rest / grows : 0.0;
    above += change;
    if (isCurve) {
      slope = saturationSlope(air.temperature + above);
      deficit = saturationPressure(air.temperature + above) - air.vapourPressure;
    } else {
      deficit = airDeficit + slope * above;
    }
    if (!isCurve || std::abs(change) <= 1e-9) {
      break;
    }
  }
  result.temperature = air.temperature + above;
  result.latent = perPressure * path * deficit;
  result.sensible = heat * above;
  result.water = result.latent / kLatentHeat;
  // a wider path for vapour cools the leaf, which takes back a part
  const double byPath = both > 0.0 ? (boundaryConductance / both) * (boundaryConductance / both) : 0.0;
  const double grows = heat + perPressure * path * slope;
  const double kept = grows > 0.0 ? heat / grows : 0.0;
  result.byConductance = perPressure * deficit * byPath * kept / kLatentHeat;
  return result;
}

double boundaryConductance(double width, double wind) {
  constexpr double kViscosity = 1.51e-5;    // of air at 20 °C, m²/s
  constexpr double kDiffusivity = 2.14e-5;  // of heat in it, m²/s
  constexpr double kLeastWind = 0.1;        // m/s: beside a warm leaf calm air moves by itself
  const double reynolds = std::max(wind, kLeastWind) * width / kViscosity;
  return 2.0 * 0.664 * kDiffusivity / width * std::sqrt(reynolds) * core::pow(kViscosity / kDiffusivity, 1.0 / 3.0);
}

double Stomata::openness(double par, double deficit) const {
  const double byPar = halfPar > 0.0 ? par / (par + halfPar) : 1.0;
  const double byDeficit = halfDeficit > 0.0 ? 1.0 / (1.0 + deficit / halfDeficit) : 1.0;
  return byPar * byDeficit;
}

double Stomata::waterPart(double head) const {
  return halfHead < 0.0 && head < 0.0 ? 1.0 / (1.0 + core::pow(head / halfHead, shape)) : 1.0;
}

double Stomata::waterPartSlope(double head) const {
  if (!(halfHead < 0.0 && head < 0.0)) {
    return 0.0;
  }
  const double part = waterPart(head);
  return -shape * part * (1.0 - part) / head;
}

}  // namespace espalier::environment
