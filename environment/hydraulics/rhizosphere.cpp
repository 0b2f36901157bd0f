#include "environment/hydraulics/rhizosphere.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

constexpr std::size_t kMostReach = 10;

/// For each reach the mean over all pairs of (2·reach + 1)² cells of the logarithm of their distance in sides.
const std::array<double, kMostReach + 1>& logDistances() {
  static const std::array<double, kMostReach + 1> distances = [] {
    std::array<double, kMostReach + 1> means{};
    for (std::size_t reach = 0; reach <= kMostReach; ++reach) {
      const auto count = static_cast<int>(2 * reach + 1);
      double sum = 0.0;
      for (int x = 1 - count; x < count; ++x) {
        for (int y = 1 - count; y < count; ++y) {
          const double distance = x == 0 && y == 0 ? 0.198 : std::sqrt(static_cast<double>(x * x + y * y));
          sum += (count - std::abs(x)) * (count - std::abs(y)) * core::log(distance);
        }
      }
      means[reach] = sum / (static_cast<double>(count) * count * count * count);
    }
    return means;
  }();
  return distances;
}

}  // namespace

double annulusFactor(double ratio) {
  const double x = ratio * ratio - 1.0;
  // close to the root the terms cancel: g = x/6 − x²/24 + … (Taylor)
  if (x < 1e-3) {
    return x / 6.0 - x * x / 24.0;
  }
  const double square = ratio * ratio;
  return square * square * core::log(ratio) / (x * x) + (1.0 - 3.0 * square) / (4.0 * x);
}

CellFactor cellFactor(double side, double radius) {
  for (std::size_t reach = 0; reach <= kMostReach; ++reach) {
    const double factor = core::log(side / radius) + logDistances()[reach];
    if (factor > 0.0) {
      return {reach, factor};
    }
  }
  return {kMostReach, 0.0};
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
