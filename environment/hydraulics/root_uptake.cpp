#include "environment/hydraulics/root_uptake.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "environment/base/number_text.h"
#include "environment/hydraulics/rhizosphere.h"

namespace espalier::environment {

namespace {

constexpr int kMostTurns = 40;
constexpr double kShortestStepDays = 1e-8;

void addTo(std::vector<double>& sums, const std::vector<double>& values, double days) {
  sums.resize(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    sums[i] += days * values[i];
  }
}

}  // namespace

void WaterSums::add(const PlantWater::Result& result, const std::vector<HydraulicTree::Node>& nodes, double passed) {
  days += passed;
  addTo(heads, result.flow.heads, passed);
  addTo(uptakes, result.flow.uptakes, passed);
  addTo(surfaceHeads, result.surfaceHeads, passed);
  addTo(given, result.given, passed);
  addTo(collarFlows, result.flow.collarFlows, passed);
  std::vector<double> collars(result.flow.collarFlows.size(), 0.0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent == HydraulicTree::kNoParent) {
      collars[nodes[i].plant] = result.flow.heads[i];
    }
  }
  addTo(collarHeads, collars, passed);
}

RootUptakeFromSoil::RootUptakeFromSoil(PlantWater& plants, SoilBody& soil, const std::vector<core::Vec3>& middles,
                                       bool hasRhizosphere)
    : plants_(&plants), soil_(&soil), cellOf_(middles.size(), -1), above_(middles.size(), 0.0) {
  const RichardsSolver& water = soil.water();
  std::vector<double> lengths(water.cellCount(), 0.0);  // of the roots in each cell
  auto& nodes = plants.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent == HydraulicTree::kNoParent) {
      continue;
    }
    if (const auto cell = soil.cellOf(middles[i])) {
      cellOf_[i] = static_cast<std::int64_t>(*cell);
      above_[i] = soil.ground().heightOf(soil.ground().middleOf(*cell)) - soil.ground().heightOf(middles[i]);
      lengths[*cell] += nodes[i].radialConductivity > 0.0 ? nodes[i].length : 0.0;
    } else {
      nodes[i].radialConductivity = 0.0;
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!hasRhizosphere || cellOf_[i] < 0 || !(nodes[i].radialConductivity > 0.0)) {
      continue;
    }
    const auto cell = static_cast<std::size_t>(cellOf_[i]);
    const double a = nodes[i].radius;
    const double volume = water.cellVolume(cell);
    // all roots of the cell share it
    const double ratio = std::sqrt(volume / (std::numbers::pi * lengths[cell]) / (a * a) + 1.0);
    const double spacing = 1.0 / std::sqrt(soil.ground().meanAround(cell, lengths) / volume);
    const double side = core::pow(volume, 1.0 / 3.0);
    plants.soils()[i] = {&water.potentialOf(cell), side < 0.5 * spacing ? cellFactor(side, a) : annulusFactor(ratio)};
  }
}

void RootUptakeFromSoil::readHeads() {
  const std::vector<double>& heads = soil_->water().state().heads;
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    if (cellOf_[i] >= 0) {
      plants_->nodes()[i].soilHead = heads[static_cast<std::size_t>(cellOf_[i])] + above_[i];
    }
  }
}

std::vector<double> RootUptakeFromSoil::sinksOf(const PlantWater::Result& result) const {
  std::vector<double> sinks(soil_->water().cellCount(), 0.0);
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    if (cellOf_[i] >= 0) {
      sinks[static_cast<std::size_t>(cellOf_[i])] += result.flow.uptakes[i];
    }
  }
  return sinks;
}

/// One internal step; returns the days that passed, or 0 when soil and plants do not come to agree.
double RootUptakeFromSoil::passStep(double days, const Limits& limits, const CollarsBetween& collars, WaterSums& sums,
                                    double& residual) {
  const std::vector<double> before = soil_->numbers();
  const double start = soil_->day();
  RichardsSolver& water = soil_->water();
  readHeads();
  auto result = plants_->solve(collars(start, start + days));
  if (!result) {
    residual = result.error();
    return 0.0;
  }
  std::vector<double> sinks = sinksOf(*result);
  std::vector<double> asked = sinks;
  std::vector<double> lastSinks, lastAsked;
  double passed = days;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    soil_->setNumbers(before);
    water.sinks() = sinks;
    passed = soil_->advance(passed);
    if (!(passed > 0.0)) {
      residual = HUGE_VAL;
      return 0.0;
    }
    readHeads();
    auto next = plants_->solve(collars(start, start + passed));
    if (!next) {
      residual = next.error();
      return 0.0;
    }
    asked = sinksOf(*next);
    residual = 0.0;
    for (std::size_t cell = 0; cell < sinks.size(); ++cell) {
      residual = std::max(residual, std::abs(asked[cell] - sinks[cell]) * passed / water.cellVolume(cell));
    }
    if (residual <= limits.tolerance) {
      // the soil gives just what the plants take: both are of one solution
      soil_->setNumbers(before);
      water.sinks() = asked;
      passed = soil_->advance(passed);
      if (passed > 0.0) {
        sums.add(*next, plants_->nodes(), passed);
      }
      return passed;
    }
    // a secant for each cell: a cell that gives more gets drier, and then is asked for less
    std::vector<double> better(sinks.size());
    for (std::size_t cell = 0; cell < sinks.size(); ++cell) {
      double slope = 0.0;
      if (!lastSinks.empty() && sinks[cell] != lastSinks[cell]) {
        slope = std::clamp((asked[cell] - lastAsked[cell]) / (sinks[cell] - lastSinks[cell]), -1e6, 0.5);
      }
      better[cell] = sinks[cell] + (asked[cell] - sinks[cell]) / (1.0 - slope);
    }
    lastSinks = std::move(sinks);
    lastAsked = asked;
    sinks = std::move(better);
  }
  return 0.0;
}

std::optional<std::string> RootUptakeFromSoil::passTime(double days, const Limits& limits,
                                                        const CollarsBetween& collars, WaterSums& sums) {
  const double end = soil_->day() + days;
  double step = limits.longestStep;
  while (end - soil_->day() > 1e-12 * std::max(1.0, end)) {
    const std::vector<double> before = soil_->numbers();
    double residual = 0.0;
    // the last two steps are of one length, so that none is very short
    const double left = end - soil_->day();
    const double longest = std::min(step, limits.longestStep);
    const double tried = left > longest && left < 2.0 * longest ? 0.5 * left : std::min(longest, left);
    const double passed = passStep(tried, limits, collars, sums, residual);
    if (passed > 0.0) {
      step = std::max(step, 2.0 * passed);
      continue;
    }
    soil_->setNumbers(before);
    step = tried / 4.0;
    if (step < kShortestStepDays) {
      return "finds no uptake that fits soil and plants on day " + numberText(soil_->day()) + ": the residual is " +
             numberText(residual) + ", the tolerance " + numberText(limits.tolerance);
    }
  }
  soil_->arriveAt(end);
  return std::nullopt;
}

}  // namespace espalier::environment
