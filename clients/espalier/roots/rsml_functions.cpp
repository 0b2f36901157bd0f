#include "clients/espalier/roots/rsml_functions.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace espalier::roots {

namespace {

/// Lengths along the root up to each point.
std::vector<double> lengthsAt(std::span<const core::Vec3> points) {
  std::vector<double> lengths(points.size());
  for (std::size_t i = 1; i < points.size(); ++i) {
    lengths[i] = lengths[i - 1] + core::length(points[i] - points[i - 1]);
  }
  return lengths;
}

/// A value at a place along a root.
struct PlacedValue {
  double position = 0.0;
  double value = 0.0;
};

/// Values at places that never decrease, between samples in the order of their positions.
std::vector<double> interpolated(std::span<const PlacedValue> samples, std::span<const double> places) {
  std::vector<double> values;
  values.reserve(places.size());
  std::size_t next = 0;  // first sample behind the place
  for (const double place : places) {
    while (next < samples.size() && samples[next].position <= place) {
      ++next;
    }
    if (next == 0 || next == samples.size()) {
      values.push_back(next == 0 ? samples.front().value : samples.back().value);
      continue;
    }
    const PlacedValue& before = samples[next - 1];
    const PlacedValue& behind = samples[next];
    values.push_back(
        std::lerp(before.value, behind.value, (place - before.position) / (behind.position - before.position)));
  }
  return values;
}

}  // namespace

tl::expected<std::vector<double>, std::string> valuesAt(const RsmlFunction& function,
                                                        std::span<const core::Vec3> points, std::string_view rootName) {
  const auto refused = [&](const std::string& what) {
    return tl::unexpected("the function '" + function.name + "' of the root '" + std::string(rootName) + "' " + what);
  };
  const auto& samples = function.samples;
  const bool isUniform = function.domain == "uniform";
  if (!isUniform && !function.domain.empty() && function.domain != "polyline" && function.domain != "length") {
    return refused("has the unknown domain '" + function.domain.substr(0, 40) + "'. Write polyline, length or uniform");
  }
  if (samples.size() == 1) {
    return std::vector<double>(points.size(), samples.front().value);
  }
  if (!isUniform && function.domain != "length") {
    if (samples.size() > points.size()) {
      return refused("has " + std::to_string(samples.size()) + " samples, and the root has " +
                     std::to_string(points.size()) + (points.size() == 1 ? " point" : " points") +
                     ". Write at most one sample for each point, or one for the whole root");
    }
    std::vector<double> values;
    std::ranges::transform(samples, std::back_inserter(values), &RsmlFunction::Sample::value);
    values.resize(points.size(), std::numeric_limits<double>::quiet_NaN());
    return values;
  }
  if (function.step && !(*function.step > 0.0)) {
    return refused("has a step that is not above 0. Correct the number");
  }
  const std::vector<double> lengths = lengthsAt(points);
  std::vector<PlacedValue> placed;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto number = static_cast<double>(i);
    if (isUniform) {
      placed.push_back({lengths.back() * (number / static_cast<double>(samples.size() - 1)), samples[i].value});
    } else if (samples[i].position || function.step) {
      placed.push_back(
          {samples[i].position.value_or(function.origin.value_or(0.0) + number * function.step.value_or(0)),
           samples[i].value});
    } else {
      return refused("has samples along the length without a position. Write it at each sample, or a step");
    }
  }
  std::ranges::stable_sort(placed, {}, &PlacedValue::position);
  return interpolated(placed, lengths);
}

}  // namespace espalier::roots
