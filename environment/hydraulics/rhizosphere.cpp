#include "environment/hydraulics/rhizosphere.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

double annulusFactor(double ratio) {
  const double x = ratio * ratio - 1.0;
  // close to the root the terms cancel: g = x/6 − x²/24 + … (Taylor)
  if (x < 1e-3) {
    return x / 6.0 - x * x / 24.0;
  }
  const double square = ratio * ratio;
  return square * square * core::log(ratio) / (x * x) + (1.0 - 3.0 * square) / (4.0 * x);
}

double cellFactor(double side, double radius) {
  return std::max(core::log(0.198 * side / radius), 0.0);
}

SoilPoint soilPointAt(const FluxPotential& potential, double head) {
  return {head, potential.at(head), potential.conductivityAt(head)};
}

RootUptake rootUptake(const FluxPotential& potential, double factor, const SoilPoint& soil, double rootConductance,
                      double xylemHead, double surfaceGuess) {
  const double ofRoot = rootConductance;
  if (xylemHead >= soil.head || factor <= 0.0) {
    return {ofRoot * (soil.head - xylemHead), ofRoot, ofRoot, soil.head};
  }
  const double ofSoil = 2.0 * std::numbers::pi / factor;
  // uptake by the root less supply by the soil grows with the head of the surface, and its slope too: Newton's method
  // between the heads of xylem and soil
  double low = xylemHead;
  double high = soil.head;
  double head = std::clamp(surfaceGuess, low, high);
  for (int round = 0; round < 100; ++round) {
    const double difference = ofRoot * (head - xylemHead) - ofSoil * (soil.phi - potential.at(head));
    (difference > 0.0 ? high : low) = head;
    double next = head - difference / (ofRoot + ofSoil * potential.conductivityAt(head));
    if (!(next > low && next < high)) {
      next = low < 0.0 && high < 0.0 ? -std::sqrt(low * high) : 0.5 * (low + high);
    }
    const double change = std::abs(next - head);
    head = next;
    if (change <= 1e-13 * std::abs(head) || high - low <= 1e-14 * std::abs(low)) {
      break;
    }
  }
  const double slope = ofSoil * potential.conductivityAt(head);
  // by the side that resists more: there rounding of the heads matters less
  const double perLength = ofRoot < slope ? ofRoot * (head - xylemHead) : ofSoil * (soil.phi - potential.at(head));
  const double part = ofRoot / (ofRoot + slope);
  return {perLength, part * slope, part * ofSoil * soil.conductivity, head};
}

}  // namespace espalier::environment
