#include "environment/hydraulics/root_uptake.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "environment/base/number_text.h"
#include "environment/hydraulics/rhizosphere.h"

namespace espalier::environment {

namespace {

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
  leaves.resize(result.leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const PlantWater::LeafState& leaf = result.leaves[i];
    leaves[i].conductance += passed * leaf.conductance;
    leaves[i].temperature += passed * leaf.temperature;
    leaves[i].waterPart += passed * leaf.waterPart;
    leaves[i].latent += passed * leaf.latent;
  }
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

bool RootUptakeFromSoil::takeAt(const std::vector<double>& heads, double days, std::vector<double>& sinks,
                                std::vector<double>& byHead) {
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    if (cellOf_[i] >= 0) {
      plants_->nodes()[i].soilHead = heads[static_cast<std::size_t>(cellOf_[i])] + above_[i];
    }
  }
  auto result = plants_->solve(collars_(soil_->day(), soil_->day() + days));
  plantError_ = result ? 0.0 : result.error();
  if (!result) {
    return false;
  }
  last_ = std::move(*result);
  std::fill(sinks.begin(), sinks.end(), 0.0);
  std::fill(byHead.begin(), byHead.end(), 0.0);
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    if (cellOf_[i] >= 0) {
      sinks[static_cast<std::size_t>(cellOf_[i])] += last_.flow.uptakes[i];
      byHead[static_cast<std::size_t>(cellOf_[i])] += plants_->bySoilHead()[i];
    }
  }
  return true;
}

void RootUptakeFromSoil::addChange(const std::vector<double>& headChanges, std::vector<double>& sinkChanges) const {
  std::vector<double> heads(cellOf_.size(), 0.0);
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    heads[i] = cellOf_[i] >= 0 ? headChanges[static_cast<std::size_t>(cellOf_[i])] : 0.0;
  }
  const std::vector<double> uptakes = plants_->changeOf(last_, heads);
  for (std::size_t i = 0; i < cellOf_.size(); ++i) {
    if (cellOf_[i] >= 0) {
      sinkChanges[static_cast<std::size_t>(cellOf_[i])] += uptakes[i];
    }
  }
}

std::optional<std::string> RootUptakeFromSoil::passTime(double days, const Limits& limits,
                                                        const CollarsBetween& collars, WaterSums& sums) {
  const double end = soil_->day() + days;
  collars_ = collars;
  while (end - soil_->day() > 1e-12 * std::max(1.0, end)) {
    core::pollWork();
    // the last two steps are of one length, so that none is very short
    const double left = end - soil_->day();
    const double longest = limits.longestStep;
    const double tried = left > longest && left < 2.0 * longest ? 0.5 * left : std::min(longest, left);
    const double passed = soil_->advance(tried, this, limits.tolerance);
    if (!(passed > 0.0)) {
      const double residual = plantError_ > 0.0 ? plantError_ : soil_->water().lastResidual();
      const std::string found = "finds no uptake that fits soil and plants on day " + numberText(soil_->day());
      return std::isfinite(residual)
                 ? found + ": the residual is " + numberText(residual) +
                       (plantError_ > 0.0 ? " of the flow in the plants" : " of the water content") +
                       ", the tolerance " + numberText(limits.tolerance)
                 : found + ": the residual has no bound";
    }
    sums.add(last_, plants_->nodes(), passed);
  }
  soil_->arriveAt(end);
  return std::nullopt;
}

}  // namespace espalier::environment
