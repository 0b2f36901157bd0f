#include "environment/hydraulics/plant_water.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "environment/hydraulics/rhizosphere.h"

namespace espalier::environment {

namespace {

constexpr int kMostRounds = 2000;
constexpr int kRoundsOfAllLeaves = 30;       // in which all leaves may change; later one a round
constexpr double kTolerance = 1e-10;         // of the flow, and of kx
constexpr double kRoundingTolerance = 1e-6;  // of what does not become better
// the slope of the uptake against a head is at least this part of that of the root, so that it can be divided by
constexpr double kLeastSlope = 1e-12;

}  // namespace

PlantWater::PlantWater(HydraulicTree tree, const Leaves& leaves, const Vessels& vessels)
    : tree_(std::move(tree)), linear_(tree_), leaves_(leaves), vessels_(vessels), soils_(tree_.nodes().size()) {}

double PlantWater::openness(double head) const {
  return leaves_.canClose ? std::clamp((head - leaves_.closed) / (leaves_.open - leaves_.closed), 0.0, 1.0) : 1.0;
}

double PlantWater::vesselPart(double head) const {
  return head < 0.0 ? 1.0 / (1.0 + core::pow(head / vessels_.half, vessels_.shape)) : 1.0;
}

/// Makes the exchange of a segment with the soil linear at its present head; returns what was wrong.
double PlantWater::updateSoil(std::size_t i, Result& result) {
  const HydraulicTree::Node& node = tree_.nodes()[i];
  if (!(node.radialConductivity > 0.0)) {
    return 0.0;
  }
  result.surfaceHeads[i] = node.soilHead;
  if (soils_[i].potential == nullptr || !(soils_[i].factor > 0.0)) {
    return 0.0;
  }
  // the mean head in the xylem follows from the uptake, which the tree gives for the whole segment
  HydraulicTree::Node& linear = linear_.nodes()[i];
  const double slope = 2.0 * std::numbers::pi * node.radius * linear.radialConductivity;
  const double found = result.flow.uptakes[i] / node.length;
  const double xylem = linear.soilHead - found / slope;
  const RootUptake uptake = rootUptake(*soils_[i].potential, soils_[i].factor, node.soilHead, node.radius,
                                       node.radialConductivity, xylem, surfaceHeads_[i]);
  const double least = kLeastSlope * 2.0 * std::numbers::pi * node.radius * node.radialConductivity;
  const double byHead = std::max(uptake.byHead, least);
  linear.radialConductivity = byHead / (2.0 * std::numbers::pi * node.radius);
  linear.soilHead = xylem + uptake.perLength / byHead;
  surfaceHeads_[i] = uptake.surfaceHead;
  result.surfaceHeads[i] = uptake.surfaceHead;
  return std::abs(uptake.perLength - found) * node.length;
}

/// Takes a leaf to the part of its curve where its head is; returns what was wrong with the water that it gives.
double PlantWater::updateLeaf(std::size_t i, Result& result, bool& maySwitch) {
  const double wanted = tree_.nodes()[i].demand;
  HydraulicTree::Node& linear = linear_.nodes()[i];
  const double head = result.flow.heads[i];
  result.given[i] = wanted * openness(head);
  if (!leaves_.canClose || !(wanted > 0.0)) {
    return 0.0;
  }
  const double found = linear.demand + linear.demandByHead * head;
  LeafPart part = head >= leaves_.open ? LeafPart::Open : head <= leaves_.closed ? LeafPart::Closed : LeafPart::Closing;
  // from one end of the curve to the other the way leads over the slope
  if (part != leafParts_[i] && leafParts_[i] != LeafPart::Closing) {
    part = LeafPart::Closing;
  }
  if (part != leafParts_[i] && maySwitch) {
    leafParts_[i] = part;
    maySwitch = result.rounds < kRoundsOfAllLeaves;
  }
  const double slope = wanted / (leaves_.open - leaves_.closed);
  const bool isClosing = leafParts_[i] == LeafPart::Closing;
  linear.demandByHead = isClosing ? slope : 0.0;
  linear.demand = isClosing ? -slope * leaves_.closed : leafParts_[i] == LeafPart::Open ? wanted : 0.0;
  return std::abs(result.given[i] - found);
}

/// Returns by which part of it kx was wrong.
double PlantWater::updateVessels(std::size_t i, const Result& result) {
  const HydraulicTree::Node& node = tree_.nodes()[i];
  if (vessels_.half == 0.0 || node.parent == HydraulicTree::kNoParent) {
    return 0.0;
  }
  double& conductance = linear_.nodes()[i].axialConductance;
  const double head = 0.5 * (result.flow.heads[i] + result.flow.heads[node.parent]);
  // vessels without any water would part the plant
  const double wanted = node.axialConductance * std::max(vesselPart(head), 1e-9);
  const double wrong = std::abs(wanted - conductance) / node.axialConductance;
  conductance = std::sqrt(wanted * conductance);
  return wrong;
}

tl::expected<PlantWater::Result, double> PlantWater::solve(std::span<const HydraulicTree::Collar> plants) {
  const std::size_t count = tree_.nodes().size();
  Result result;
  result.surfaceHeads.assign(count, 0.0);
  result.given.assign(count, 0.0);
  const auto resists = [](const Soil& soil) { return soil.potential != nullptr && soil.factor > 0.0; };
  const bool isLinear =
      !leaves_.canClose && vessels_.half == 0.0 && std::none_of(soils_.begin(), soils_.end(), resists);
  // the last round of an earlier solution is the best start, unless what is around has changed its kind
  if (surfaceHeads_.size() != count || isLinear) {
    linear_ = tree_;
    surfaceHeads_.resize(count);
    leafParts_.assign(count, LeafPart::Open);
    for (std::size_t i = 0; i < count; ++i) {
      surfaceHeads_[i] = tree_.nodes()[i].soilHead;
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!resists(soils_[i])) {
      linear_.nodes()[i].soilHead = tree_.nodes()[i].soilHead;
    }
    if (!leaves_.canClose) {
      linear_.nodes()[i].demand = tree_.nodes()[i].demand;
    }
  }
  double wrong = 0.0;
  double least = HUGE_VAL;
  int idle = 0;  // rounds since the error became much smaller
  for (result.rounds = 1; result.rounds <= kMostRounds; ++result.rounds) {
    result.flow = linear_.solve(plants);
    double all = 0.0;
    double wrongFlow = 0.0;
    double wrongVessels = 0.0;
    bool maySwitch = true;
    for (std::size_t i = 0; i < count; ++i) {
      wrongFlow += updateSoil(i, result) + updateLeaf(i, result, maySwitch);
      wrongVessels = std::max(wrongVessels, updateVessels(i, result));
      all += std::abs(result.flow.uptakes[i]) + std::abs(result.given[i]);
    }
    wrong = std::max(all > 0.0 ? wrongFlow / all : 0.0, wrongVessels);
    if (!std::isfinite(all) || !std::isfinite(wrong)) {
      break;
    }
    idle = wrong < 0.5 * least ? 0 : idle + 1;
    least = std::min(least, wrong);
    // what rounding leaves does not become smaller
    if (isLinear || wrong <= kTolerance || (wrong <= kRoundingTolerance && idle >= 4)) {
      return result;
    }
  }
  surfaceHeads_.clear();
  return tl::unexpected(wrong);
}

}  // namespace espalier::environment
