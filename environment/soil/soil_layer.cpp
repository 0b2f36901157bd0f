#include "environment/soil/soil_layer.h"

#include <algorithm>
#include <cmath>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {
constexpr double kDriestHead = -1e7;
// α|h| below which K is taken as a straight line to its saturated value: its slope has no bound at 0 when n is below 2
constexpr double kStraight = 1e-4;
}  // namespace

double SoilLayer::saturation(double head) const {
  if (head >= 0.0) {
    return 1.0;
  }
  if (function == Function::Gardner) {
    return core::exp(alpha * head);
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
  if (function == Function::Gardner) {
    return (saturatedContent - residualContent) * alpha * core::exp(alpha * head);
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
  if (function == Function::Gardner) {
    return conductivity * core::exp(alpha * head);
  }
  const double straight = -kStraight / alpha;
  if (n < 2.0 && head > straight) {
    const double part = head / straight;
    return (1.0 - part) * conductivity + part * conductivityAt(straight);
  }
  const double m = 1.0 - 1.0 / n;
  // as in saturation(), with the power that the film needs, too
  const double power = core::pow(-alpha * head, n);
  const double effective = core::pow(1.0 + power, 1.0 / n - 1.0);
  // 1 − (1 − Se^(1/m))^m, written with the suction: Se^(1/m) is 1/(1 + s)
  const double film = -core::expm1(m * core::log(power / (1.0 + power)));
  return conductivity * std::sqrt(effective) * film * film;
}

double SoilLayer::headAt(double content) const {
  if (content >= saturatedContent) {
    return specificStorage > 0.0 ? (content - saturatedContent) / specificStorage : 0.0;
  }
  return headAtSaturation((content - residualContent) / (saturatedContent - residualContent));
}

double SoilLayer::headAtSaturation(double effective) const {
  if (!(effective > 0.0)) {
    return kDriestHead;
  }
  if (function == Function::Gardner) {
    return std::max(core::log(effective) / alpha, kDriestHead);
  }
  const double m = 1.0 - 1.0 / n;
  const double suction = core::pow(core::pow(effective, -1.0 / m) - 1.0, 1.0 / n) / alpha;
  return std::max(-suction, kDriestHead);
}

double SoilLayer::conductivitySlope(double head) const {
  if (head >= 0.0) {
    return 0.0;
  }
  if (function == Function::Gardner) {
    return alpha * conductivity * core::exp(alpha * head);
  }
  const double straight = -kStraight / alpha;
  if (n < 2.0 && head > straight) {
    return (conductivity - conductivityAt(straight)) / -straight;
  }
  // K = Ks √S f², with f = 1 − (s/(1 + s))^m, s = (α|h|)^n
  const double m = 1.0 - 1.0 / n;
  const double power = core::pow(-alpha * head, n);
  const double part = core::pow(power / (1.0 + power), m);
  const double film = -core::expm1(m * core::log(power / (1.0 + power)));
  const double byLog = n / (1.0 + power);  // d ln(s/(1 + s))/d ln|h|
  const double root = std::sqrt(saturation(head));
  const double byLogOfRoot = -0.5 * m * n * power / (1.0 + power) * root;
  const double byLogOfFilm = -m * part * byLog;
  return conductivity * (byLogOfRoot * film * film + 2.0 * root * film * byLogOfFilm) / head;
}

SoilLayer::Functions SoilLayer::at(double head) const {
  const double straight = -kStraight / alpha;
  if (head >= 0.0 || function == Function::Gardner || (n < 2.0 && head > straight)) {
    return {content(head), capacity(head), conductivityAt(head), conductivitySlope(head)};
  }
  // as in the functions above, with each power computed once
  const double m = 1.0 - 1.0 / n;
  const double suction = -alpha * head;
  const double power = core::pow(suction, n);
  const double effective = core::pow(1.0 + power, 1.0 / n - 1.0);
  const double film = -core::expm1(m * core::log(power / (1.0 + power)));
  const double part = core::pow(power / (1.0 + power), m);
  const double root = std::sqrt(effective);
  const double byLogOfRoot = -0.5 * m * n * power / (1.0 + power) * root;
  const double byLogOfFilm = -m * part * (n / (1.0 + power));
  return {residualContent + (saturatedContent - residualContent) * effective + specificStorage * 0.0,
          (saturatedContent - residualContent) * m * n * alpha * core::pow(suction, n - 1.0) *
              core::pow(1.0 + power, -m - 1.0),
          conductivity * root * film * film,
          conductivity * (byLogOfRoot * film * film + 2.0 * root * film * byLogOfFilm) / head};
}

}  // namespace espalier::environment
