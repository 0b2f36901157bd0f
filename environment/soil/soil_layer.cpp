#include "environment/soil/soil_layer.h"

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {
constexpr double kDriestHead = -1e7;
}

double SoilLayer::saturation(double head) const {
  if (head >= 0.0) {
    return 1.0;
  }
  return core::pow(1.0 + core::pow(-alpha * head, n), 1.0 / n - 1.0);
}

double SoilLayer::content(double head) const {
  return residualContent + (saturatedContent - residualContent) * saturation(head) +
         specificStorage * std::max(head, 0.0);
}

double SoilLayer::capacity(double head) const {
  if (head >= 0.0) {
    return specificStorage;
  }
  const double m = 1.0 - 1.0 / n;
  const double suction = -alpha * head;
  return (saturatedContent - residualContent) * m * n * alpha * core::pow(suction, n - 1.0) *
         core::pow(1.0 + core::pow(suction, n), -m - 1.0);
}

double SoilLayer::conductivityAt(double head) const {
  if (head >= 0.0) {
    return conductivity;
  }
  const double m = 1.0 - 1.0 / n;
  const double effective = saturation(head);
  // 1 − (1 − Se^(1/m))^m, written with the suction: Se^(1/m) is 1/(1 + s)
  const double power = core::pow(-alpha * head, n);
  const double film = -core::expm1(m * core::log(power / (1.0 + power)));
  return conductivity * std::sqrt(effective) * film * film;
}

double SoilLayer::headAt(double content) const {
  if (content >= saturatedContent) {
    return specificStorage > 0.0 ? (content - saturatedContent) / specificStorage : 0.0;
  }
  const double effective = (content - residualContent) / (saturatedContent - residualContent);
  if (!(effective > 0.0)) {
    return kDriestHead;
  }
  const double m = 1.0 - 1.0 / n;
  const double suction = core::pow(core::pow(effective, -1.0 / m) - 1.0, 1.0 / n) / alpha;
  return std::max(-suction, kDriestHead);
}

}  // namespace espalier::environment
