#include "clients/espalier/validation/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::validation {

namespace {

using std::numbers::pi;

/// By the midpoint rule.
template <typename Value>
double integralOf(double from, double to, int steps, const Value& value) {
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    sum += value(from + (to - from) * (i + 0.5) / steps);
  }
  return sum * (to - from) / steps;
}

double campbellProjection(double ratio, double cosine, double sine) {
  double norm = 2.0;
  if (ratio < 1.0) {
    const double e = std::sqrt(1.0 - ratio * ratio);
    norm = ratio + core::asin(e) / e;
  } else if (ratio > 1.0) {
    const double e = std::sqrt(1.0 - 1.0 / (ratio * ratio));
    norm = ratio + core::log((1.0 + e) / (1.0 - e)) / (2.0 * e * ratio);
  }
  return std::sqrt(ratio * ratio * cosine * cosine + sine * sine) / norm;
}

/// The distributions of de Wit (1965): density of leaf angles, but for the factor 2/π.
double deWit(const std::string& leaves, double angle) {
  if (leaves == "planophile" || leaves == "erectophile") {
    return leaves == "planophile" ? 1.0 + core::cos(2.0 * angle) : 1.0 - core::cos(2.0 * angle);
  }
  if (leaves == "plagiophile" || leaves == "extremophile") {
    return leaves == "extremophile" ? 1.0 + core::cos(4.0 * angle) : 1.0 - core::cos(4.0 * angle);
  }
  return 1.0;  // uniform
}

}  // namespace

LayerFluxes horizontalLayer(double leafAreaIndex, double rho, double tau, double ground) {
  double reflected = 0.0;
  double passed = 0.0;
  if (std::abs(1.0 - rho - tau) < 1e-12) {
    reflected = rho * leafAreaIndex / (1.0 + rho * leafAreaIndex);
    passed = 1.0 - reflected;
  } else {
    const double k = std::sqrt((1.0 - tau) * (1.0 - tau) - rho * rho);
    const double r = rho == 0.0 ? 0.0 : (1.0 - tau - k) / rho;
    const double both = core::exp(-2.0 * k * leafAreaIndex);
    reflected = r * (1.0 - both) / (1.0 - r * r * both);
    passed = (1.0 - r * r) * core::exp(-k * leafAreaIndex) / (1.0 - r * r * both);
  }
  const double down = passed / (1.0 - ground * reflected);
  const double up = reflected + ground * passed * down;
  return {up, 1.0 - up - (1.0 - ground) * down, down};
}

double leafProjection(const std::string& leaves, double ratio, double zenithRadians) {
  const double cosine = core::cos(zenithRadians);
  const double sine = core::sin(zenithRadians);
  if (leaves == "horizontal" || leaves == "vertical") {
    return leaves == "horizontal" ? cosine : 2.0 / pi * sine;
  }
  if (leaves == "spherical") {
    return 0.5;
  }
  if (leaves == "ellipsoidal") {
    return campbellProjection(ratio, cosine, sine);
  }
  // leaves steeper than the beam's complement turn both of their sides to it
  const auto lit = [&](double angle) {
    const double flat = core::cos(angle) * cosine;
    const double steep = core::sin(angle) * sine;
    if (flat >= steep) {
      return flat * deWit(leaves, angle);
    }
    const double turn = core::acos(std::clamp(flat / steep, -1.0, 1.0));
    return flat * (1.0 + 2.0 / pi * (core::tan(turn) - turn)) * deWit(leaves, angle);
  };
  constexpr int kSteps = 100'000;
  const double border = 0.5 * pi - zenithRadians;
  return 2.0 / pi * (integralOf(0.0, border, kSteps, lit) + integralOf(border, 0.5 * pi, kSteps, lit));
}

LeafAngleTable::LeafAngleTable(const std::string& leaves, double ratio) {
  if (leaves == "horizontal" || leaves == "vertical") {
    only_ = leaves == "horizontal" ? 0.0 : 0.5 * pi;
    return;
  }
  constexpr int kSteps = 2000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = 0.5 * pi * (i + 0.5) / kSteps;
    const double sine = core::sin(angle);
    const double cosine = core::cos(angle);
    if (leaves == "spherical") {
      sum += sine;
    } else if (leaves == "ellipsoidal") {
      // the surface of the ellipsoid by its normals
      const double square = cosine * cosine + ratio * ratio * sine * sine;
      sum += sine / (square * square);
    } else {
      sum += deWit(leaves, angle);
    }
    cumulated_.push_back(sum);
  }
}

double LeafAngleTable::at(double part) const {
  if (only_ >= 0.0) {
    return only_;
  }
  const double area = part * cumulated_.back();
  const auto next = std::lower_bound(cumulated_.begin(), cumulated_.end() - 1, area);
  const double before = next == cumulated_.begin() ? 0.0 : *(next - 1);
  const double step = static_cast<double>(next - cumulated_.begin()) + (area - before) / (*next - before);
  return 0.5 * pi * step / static_cast<double>(cumulated_.size());
}

double passedBlackLeaves(const std::string& leaves, double ratio, const std::string& light, double leafAreaIndex) {
  if (light.starts_with("zenith")) {
    const double zenith = std::stod(light.substr(6)) * pi / 180.0;
    return core::exp(-leafProjection(leaves, ratio, zenith) * leafAreaIndex / core::cos(zenith));
  }
  const auto radiance = [&](double cosine) { return light == "uniform" ? 1.0 : (1.0 + 2.0 * cosine) / 3.0; };
  constexpr int kSteps = 2000;
  const double passed = integralOf(0.0, 1.0, kSteps, [&](double cosine) {
    return radiance(cosine) * cosine *
           core::exp(-leafProjection(leaves, ratio, core::acos(cosine)) * leafAreaIndex / cosine);
  });
  return passed / integralOf(0.0, 1.0, kSteps, [&](double cosine) { return radiance(cosine) * cosine; });
}

double viewFactor(const std::string& kind, double p1, double p2, double p3) {
  const double x = p1 / p3;
  const double y = p2 / p3;
  if (kind == "sphere") {
    return core::atan(std::sqrt(1.0 / (1.0 / (x * x) + 1.0 / (y * y) + 1.0 / (x * x * y * y)))) / (4.0 * pi);
  }
  if (kind == "discs") {
    const double sum = 1.0 + (1.0 + y * y) / (x * x);
    return 0.5 * (sum - std::sqrt(sum * sum - 4.0 * (p2 / p1) * (p2 / p1)));
  }
  const double xx = x * x;
  const double yy = y * y;
  if (kind == "rectangles") {
    const double ofX = std::sqrt(1.0 + xx);
    const double ofY = std::sqrt(1.0 + yy);
    return 2.0 / (pi * x * y) *
           (0.5 * core::log((1.0 + xx) * (1.0 + yy) / (1.0 + xx + yy)) + x * ofY * core::atan(x / ofY) +
            y * ofX * core::atan(y / ofX) - x * core::atan(x) - y * core::atan(y));
  }
  const double both = xx + yy;
  const double root = std::sqrt(both);
  return 1.0 / (pi * x) *
         (x * core::atan(1.0 / x) + y * core::atan(1.0 / y) - root * core::atan(1.0 / root) +
          0.25 * (core::log((1.0 + xx) * (1.0 + yy) / (1.0 + both)) +
                  xx * core::log(xx * (1.0 + both) / ((1.0 + xx) * both)) +
                  yy * core::log(yy * (1.0 + both) / ((1.0 + yy) * both))));
}

double lensArea(double first, double second, double distance) {
  const double x = (distance * distance + first * first - second * second) / (2.0 * distance);
  const double y = distance - x;
  return first * first * core::acos(x / first) + second * second * core::acos(y / second) -
         distance * std::sqrt(first * first - x * x);
}

}  // namespace espalier::validation
