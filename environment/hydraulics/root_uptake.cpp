#include "environment/hydraulics/root_uptake.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/world.h"
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
                                       const std::vector<std::uint8_t>& axes, bool hasRhizosphere)
    : plants_(&plants), soil_(&soil) {
  const RichardsSolver& water = soil.water();
  std::vector<double> lengths(water.cellCount(), 0.0);  // of the roots in each cell
  auto& nodes = plants.nodes();
  std::vector<std::optional<std::size_t>> cellOf(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent == HydraulicTree::kNoParent) {
      continue;
    }
    cellOf[i] = soil.cellOf(middles[i]);
    if (cellOf[i]) {
      lengths[*cellOf[i]] += nodes[i].radialConductivity > 0.0 ? nodes[i].length : 0.0;
    } else {
      nodes[i].radialConductivity = 0.0;
    }
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    firstShare_.push_back(shares_.size());
    if (!cellOf[i]) {
      continue;
    }
    const std::size_t cell = *cellOf[i];
    std::size_t reach = 0;
    if (hasRhizosphere && nodes[i].radialConductivity > 0.0) {
      const double a = nodes[i].radius;
      const double volume = water.cellVolume(cell);
      const double spacing = 1.0 / std::sqrt(soil.ground().meanAround(cell, lengths) / volume);
      const double side = soil.ground().sideAcross(cell, axes[i]);
      plants.soils()[i].potential = &water.potentialOf(cell);
      if (side < 0.5 * spacing) {
        const CellFactor found = cellFactor(side, a);
        plants.soils()[i].factor = found.factor;
        reach = found.reach;
      } else {
        // all roots of the cell share it
        const double ratio = std::sqrt(volume / (std::numbers::pi * lengths[cell]) / (a * a) + 1.0);
        plants.soils()[i].factor = annulusFactor(ratio);
      }
    }
    addShares(cell, reach, middles[i], axes[i]);
  }
  firstShare_.push_back(shares_.size());
}

/// Shares the uptake of a segment among the soil around it, by volume.
void RootUptakeFromSoil::addShares(std::size_t cell, std::size_t reach, const core::Vec3& middle, std::uint8_t axis) {
  const Ground& ground = soil_->ground();
  const std::size_t first = shares_.size();
  double volume = 0.0;
  for (const std::size_t one : ground.cellsAcross(cell, reach, axis)) {
    if (soil_->water().isSoil(one)) {
      const double own = soil_->water().cellVolume(one);
      shares_.push_back({one, own, ground.heightOf(ground.middleOf(one)) - ground.heightOf(middle)});
      volume += own;
    }
  }
  for (std::size_t i = first; i < shares_.size(); ++i) {
    shares_[i].part /= volume;
  }
}

bool RootUptakeFromSoil::takeAt(const std::vector<double>& heads, double days, std::vector<double>& sinks,
                                std::vector<double>& byHead) {
  for (std::size_t i = 0; i + 1 < firstShare_.size(); ++i) {
    double head = 0.0;
    for (const Share& share : sharesOf(i)) {
      head += share.part * (heads[share.cell] + share.above);
    }
    if (!sharesOf(i).empty()) {
      plants_->nodes()[i].soilHead = head;
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
  for (std::size_t i = 0; i + 1 < firstShare_.size(); ++i) {
    for (const Share& share : sharesOf(i)) {
      sinks[share.cell] += share.part * last_.flow.uptakes[i];
      byHead[share.cell] += share.part * share.part * plants_->bySoilHead()[i];
    }
  }
  return true;
}

void RootUptakeFromSoil::addChange(const std::vector<double>& headChanges, std::vector<double>& sinkChanges) const {
  std::vector<double> heads(firstShare_.size() - 1, 0.0);
  for (std::size_t i = 0; i < heads.size(); ++i) {
    for (const Share& share : sharesOf(i)) {
      heads[i] += share.part * headChanges[share.cell];
    }
  }
  const std::vector<double> uptakes = plants_->changeOf(last_, heads);
  for (std::size_t i = 0; i < uptakes.size(); ++i) {
    for (const Share& share : sharesOf(i)) {
      sinkChanges[share.cell] += share.part * uptakes[i];
    }
  }
}

std::optional<std::string> RootUptakeFromSoil::passTime(double days, const Limits& limits,
                                                        const CollarsBetween& collars, WaterSums& sums) {
  const double end = turtle::endOfStep(soil_->day(), days);
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
