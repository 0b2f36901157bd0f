#include "environment/soil/flux_potential.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

// nodes over suctions from 10⁻⁸ to 10⁸ times 1/α
constexpr double kFirst = 1e-8;
constexpr double kLast = 1e8;
constexpr std::size_t kNodeCount = 2048;
const double kSpacing = core::log(kLast / kFirst) / static_cast<double>(kNodeCount - 1);

// α|h| below which the mean of K is that of both ends: its slope by one of them has no bound there
constexpr double kNearSaturation = 1e-4;

/// ∫ K dh over one interval of ln(−h), by Gauss's formula with five points.
double integralOver(const SoilLayer& soil, double from) {
  constexpr std::array<double, 5> kPoints{-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                          0.906179845938664};
  constexpr std::array<double, 5> kWeights{0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366,
                                           0.236926885056189};
  double sum = 0.0;
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const double suction = core::exp(from + 0.5 * kSpacing * (1.0 + kPoints[i]));
    sum += kWeights[i] * soil.conductivityAt(-suction) * suction;
  }
  return 0.5 * kSpacing * sum;
}

}  // namespace

FluxPotential::FluxPotential(const SoilLayer& soil)
    : soil_(soil),
      firstLog_(core::log(kFirst / soil.alpha)),
      phi_(kNodeCount),
      missing_(kNodeCount),
      slope_(kNodeCount) {
  for (std::size_t node = 0; node < kNodeCount; ++node) {
    const double suction = core::exp(firstLog_ + kSpacing * static_cast<double>(node));
    slope_[node] = soil.conductivityAt(-suction) * suction;
  }
  // beyond the driest node K falls as a power of h, so what is left is about K·|h|, far below the first digits
  phi_.back() = slope_.back();
  missing_.front() = slope_.front();
  std::vector<double> parts(kNodeCount - 1);
  for (std::size_t node = 0; node + 1 < kNodeCount; ++node) {
    parts[node] = integralOver(soil, firstLog_ + kSpacing * static_cast<double>(node));
    missing_[node + 1] = missing_[node] + parts[node];
  }
  for (std::size_t node = kNodeCount - 1; node-- > 0;) {
    phi_[node] = phi_[node + 1] + parts[node];
  }
}

double FluxPotential::interpolate(const std::vector<double>& table, double head) const {
  const double place = (core::log(-head) - firstLog_) / kSpacing;
  if (!(place > 0.0)) {
    return table.front();
  }
  const auto node = static_cast<std::size_t>(place);
  if (node + 1 >= kNodeCount) {
    return table.back();
  }
  const double t = place - static_cast<double>(node);
  const double rest = 1.0 - t;
  // Hermite's polynomial of the values and slopes at both nodes; one of the tables rises, the other falls
  const double sign = table[node + 1] > table[node] ? 1.0 : -1.0;
  return table[node] + t * t * (3.0 - 2.0 * t) * (table[node + 1] - table[node]) +
         sign * kSpacing * t * rest * (rest * slope_[node] - t * slope_[node + 1]);
}

double FluxPotential::at(double head) const {
  return head < 0.0 ? interpolate(phi_, head) : phi_.front() + soil_.conductivityAt(0.0) * head;
}

double FluxPotential::missingAt(double head) const {
  return head < 0.0 ? interpolate(missing_, head) : -soil_.conductivityAt(0.0) * head;
}

FluxPotential::Mean FluxPotential::meanBetween(const Point& a, const Point& b) const {
  const double difference = a.head - b.head;
  const double largest = std::max(std::abs(a.head), std::abs(b.head));
  if (soil_.alpha * largest <= kNearSaturation || std::abs(difference) <= 1e-5 * largest) {
    return {0.5 * (a.conductivity + b.conductivity), 0.5 * a.conductivitySlope, 0.5 * b.conductivitySlope};
  }
  const bool isWet = -soil_.alpha * std::min(a.head, b.head) < 1.0;
  const double mean = (isWet ? b.missing - a.missing : a.phi - b.phi) / difference;
  return {mean, (a.conductivity - mean) / difference, (mean - b.conductivity) / difference};
}

double FluxPotential::headAt(double potential) const {
  if (potential >= phi_.front()) {
    return (potential - phi_.front()) / soil_.conductivityAt(0.0);
  }
  // phi_ falls from node to node
  const auto after =
      std::upper_bound(phi_.begin(), phi_.end(), potential, [](double one, double node) { return one > node; });
  if (after == phi_.end()) {
    return -core::exp(firstLog_ + kSpacing * static_cast<double>(kNodeCount - 1));
  }
  double low = firstLog_ + kSpacing * static_cast<double>(after - phi_.begin() - 1);
  double high = low + kSpacing;
  for (int round = 0; round < 60 && high - low > 1e-15 * std::abs(low); ++round) {
    const double middle = 0.5 * (low + high);
    (at(-core::exp(middle)) > potential ? low : high) = middle;
  }
  return -core::exp(0.5 * (low + high));
}

}  // namespace espalier::environment
