#include "environment/hydraulics/plant_water.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"

namespace espalier::environment {

namespace {

constexpr int kMostTreeRounds = 2000;
constexpr int kRoundsOfAllLeaves = 30;       // in which all leaves may change; later one a round
constexpr double kTolerance = 1e-10;         // of the flow, and of kx
constexpr double kRoundingTolerance = 1e-6;  // of what does not become better
constexpr double kRounding = 1e-13;          // of heads, where flows nearly cancel

/// The water that leaves ask for and roots cannot take at any head: it would come in at collars that give nothing off.
double missingWater(const HydraulicTree::Result& flow, std::span<const HydraulicTree::Collar> plants) {
  double missing = 0.0;
  for (std::size_t plant = 0; plant < flow.collarFlows.size(); ++plant) {
    const HydraulicTree::Collar& collar = plants[plants.size() == 1 ? 0 : plant];
    if (!collar.hasHead && flow.isFlowGiven[plant] == 0) {
      missing += std::max(std::min(collar.flow, 0.0) - flow.collarFlows[plant], 0.0);
    }
  }
  return missing;
}

}  // namespace

PlantWater::PlantWater(HydraulicTree tree, const Leaves& leaves, const Vessels& vessels)
    : tree_(std::move(tree)), leaves_(leaves), vessels_(vessels), soils_(tree_.nodes().size()) {}

double PlantWater::openness(double head) const {
  return leaves_.canClose ? std::clamp((head - leaves_.closed) / (leaves_.open - leaves_.closed), 0.0, 1.0) : 1.0;
}

double PlantWater::vesselPart(double head) const {
  return head < 0.0 ? 1.0 / (1.0 + core::pow(head / vessels_.half, vessels_.shape)) : 1.0;
}

/// Makes the exchange of a segment with the soil linear at its present head; returns what was wrong.
///
/// The surface of a segment has one head ψ, and so exchanges 2·half·(ψ − m) with a xylem of the mean head m of both
/// ends. The same passes through the soil. The flow along the xylem does not depend on the soil.
double PlantWater::updateSoil(std::size_t i, Result& result) {
  const HydraulicTree::Node& node = tree_.nodes()[i];
  const HydraulicTree::Segment& root = roots_[i];
  bySoilHead_[i] = 2.0 * root.half;
  if (!(root.half > 0.0)) {
    return 0.0;
  }
  result.surfaceHeads[i] = node.soilHead;
  if (!resists(i)) {
    return 0.0;
  }
  const double xylem = 0.5 * (result.flow.heads[i] + result.flow.heads[node.parent]);
  const RootUptake uptake = rootUptake(*soils_[i].potential, soils_[i].factor, soilPoints_[i],
                                       2.0 * root.half / node.length, xylem, surfaceHeads_[i]);
  HydraulicTree::Segment& segment = segments_[i];
  segment.half = 0.5 * uptake.byHead * node.length;
  segment.through = root.through + 0.5 * (root.half - segment.half);
  segment.supply = 0.5 * uptake.perLength * node.length + segment.half * xylem;
  bySoilHead_[i] = uptake.bySoilHead * node.length;
  surfaceHeads_[i] = uptake.surfaceHead;
  result.surfaceHeads[i] = uptake.surfaceHead;
  return std::abs(uptake.perLength * node.length - result.flow.uptakes[i]);
}

/// Takes a leaf to the part of its curve where its head is; returns what was wrong with the water that it gives.
double PlantWater::updateLeaf(std::size_t i, Result& result, bool& maySwitch) {
  const double wanted = tree_.nodes()[i].demand;
  HydraulicTree::Segment& linear = segments_[i];
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

void PlantWater::setStomata(const Stomata& stomata, bool isCurve) {
  stomata_ = stomata;
  isCurve_ = isCurve;
  gasLeaves_.assign(tree_.nodes().size(), {});
}

LeafExchange PlantWater::exchangeAt(const GasLeaf& leaf, double head) const {
  const double conductance = stomata_.least + leaf.open * stomata_.waterPart(head);
  return leafExchange(leaf.air, leaf.netRadiation, leaf.boundary, conductance, isCurve_);
}

/// Makes a leaf with stomata linear near its present head; returns what was wrong with the water that it gives.
double PlantWater::updateGasLeaf(std::size_t i, Result& result) {
  if (gasLeaves_.empty() || !(gasLeaves_[i].flow > 0.0)) {
    return 0.0;
  }
  const GasLeaf& leaf = gasLeaves_[i];
  HydraulicTree::Segment& segment = segments_[i];
  const double head = result.flow.heads[i];
  const LeafExchange now = exchangeAt(leaf, head);
  // dew stays on the leaf
  result.given[i] = std::max(now.water, 0.0) * leaf.flow;
  result.leaves[i] = {stomata_.least + leaf.open * stomata_.waterPart(head), now.temperature, stomata_.waterPart(head),
                      now.latent};
  const double found = segment.demand + segment.demandByHead * head;
  segment.demandByHead =
      now.water > 0.0 ? std::max(now.byConductance * leaf.open * stomata_.waterPartSlope(head), 0.0) * leaf.flow : 0.0;
  segment.demand = result.given[i] - segment.demandByHead * head;
  return std::abs(result.given[i] - found);
}

/// Returns by which part of it kx was wrong.
double PlantWater::updateVessels(std::size_t i, const Result& result) {
  const HydraulicTree::Node& node = tree_.nodes()[i];
  if (vessels_.half == 0.0 || node.parent == HydraulicTree::kNoParent) {
    return 0.0;
  }
  double& conductance = axialConductances_[i];
  const double head = 0.5 * (result.flow.heads[i] + result.flow.heads[node.parent]);
  // vessels without any water would part the plant
  const double wanted = node.axialConductance * std::max(vesselPart(head), 1e-9);
  const double wrong = std::abs(wanted - conductance) / node.axialConductance;
  conductance = std::sqrt(wanted * conductance);
  // the segment with that conductance; its exchange with the soil stays that of this round
  HydraulicTree::Node changed = node;
  changed.axialConductance = conductance;
  roots_[i] = HydraulicTree::segmentOf(changed);
  HydraulicTree::Segment& segment = segments_[i];
  segment.gravity = roots_[i].gravity;
  if (!resists(i)) {
    segment.half = roots_[i].half;
    segment.supply = roots_[i].supply;
  }
  segment.half = std::min(segment.half, roots_[i].half);
  segment.through = roots_[i].through + 0.5 * (roots_[i].half - segment.half);
  return wrong;
}

/// Prepares the first round. The last round of an earlier solution is the best start.
void PlantWater::begin() {
  const std::size_t count = tree_.nodes().size();
  const bool isNew = segments_.size() != count;
  if (isNew) {
    axialConductances_.resize(count);
    surfaceHeads_.resize(count);
    bySoilHead_.assign(count, 0.0);
    leafParts_.assign(count, LeafPart::Open);
    for (std::size_t i = 0; i < count; ++i) {
      axialConductances_[i] = tree_.nodes()[i].axialConductance;
      surfaceHeads_[i] = tree_.nodes()[i].soilHead;
    }
  }
  roots_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    HydraulicTree::Node node = tree_.nodes()[i];
    node.axialConductance = axialConductances_[i];
    roots_[i] = HydraulicTree::segmentOf(node);
  }
  soilPoints_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (resists(i)) {
      soilPoints_[i] = soilPointAt(*soils_[i].potential, tree_.nodes()[i].soilHead);
    }
  }
  if (isNew) {
    segments_ = roots_;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (!resists(i)) {
      segments_[i].supply = roots_[i].supply;
    }
    if (!leaves_.canClose && gasLeaves_.empty()) {
      segments_[i].demand = roots_[i].demand;
    }
  }
}

/// The residuals at heads that lie a share of the way from point_ to the solution of the linear tree: the old residuals
/// shrink by that share, and the part that is not linear is added. Returns the sum of the amounts.
double PlantWater::residualsAt(const std::vector<double>& heads, double share, Residuals& residuals) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < heads.size(); ++i) {
    const HydraulicTree::Node& node = tree_.nodes()[i];
    const HydraulicTree::Segment& segment = segments_[i];
    residuals.soil[i] = 0.0;
    residuals.leaf[i] = 0.0;
    if (roots_[i].half > 0.0 && resists(i)) {
      const double xylem = 0.5 * (heads[i] + heads[node.parent]);
      const RootUptake uptake = rootUptake(*soils_[i].potential, soils_[i].factor, soilPoints_[i],
                                           2.0 * roots_[i].half / node.length, xylem, surfaceHeads_[i]);
      residuals.soil[i] = (1.0 - share) * residuals_.soil[i] + uptake.perLength * node.length -
                          2.0 * (segment.supply - segment.half * xylem);
    }
    if (gasLeaves_[i].flow > 0.0) {
      residuals.leaf[i] = (1.0 - share) * residuals_.leaf[i] +
                          std::max(exchangeAt(gasLeaves_[i], heads[i]).water, 0.0) * gasLeaves_[i].flow -
                          (segment.demand + segment.demandByHead * heads[i]);
    }
    sum += std::abs(residuals.soil[i]) + std::abs(residuals.leaf[i]);
  }
  return sum;
}

/// Goes from point_ towards `heads`, the solution of the linear tree, as far as what is wrong becomes smaller than
/// `before`; the first time all the way. Returns what is wrong there. `heads` are then those of the new point.
double PlantWater::goTowards(std::vector<double>& heads, double before, bool isFirst) {
  constexpr double kLeastShare = 1e-12;
  Residuals found{std::vector<double>(heads.size()), std::vector<double>(heads.size())};
  if (isFirst) {
    residuals_ = found;
    point_ = heads;
  }
  const std::vector<double> end = heads;
  double sum = 0.0;
  for (double share = 1.0;; share *= 0.5) {
    for (std::size_t i = 0; i < heads.size(); ++i) {
      heads[i] = share < 1.0 ? point_[i] + share * (end[i] - point_[i]) : end[i];
    }
    sum = residualsAt(heads, share, found);
    if (isFirst || sum <= (1.0 - 1e-4 * share) * before || share < kLeastShare) {
      break;
    }
  }
  residuals_ = std::move(found);
  point_ = heads;
  return sum;
}

PlantWater::Wrong PlantWater::update(Result& result) {
  Wrong wrong;
  bool maySwitch = true;
  for (std::size_t i = 0; i < tree_.nodes().size(); ++i) {
    wrong.flow += updateSoil(i, result) + updateLeaf(i, result, maySwitch) + updateGasLeaf(i, result);
    wrong.vessels = std::max(wrong.vessels, updateVessels(i, result));
    wrong.rounding +=
        kRounding * roots_[i].half * (std::abs(result.flow.heads[i]) + std::abs(tree_.nodes()[i].soilHead));
  }
  return wrong;
}

tl::expected<PlantWater::Result, double> PlantWater::solve(std::span<const HydraulicTree::Collar> plants) {
  const std::size_t count = tree_.nodes().size();
  Result result;
  result.surfaceHeads.assign(count, 0.0);
  result.given.assign(count, 0.0);
  result.leaves.resize(gasLeaves_.size());
  begin();
  bool isLinear = !leaves_.canClose && gasLeaves_.empty() && vessels_.half == 0.0;
  for (std::size_t i = 0; i < count && isLinear; ++i) {
    isLinear = !resists(i);
  }
  double error = 0.0;
  double least = HUGE_VAL;
  int idle = 0;           // rounds since the error became much smaller
  double sum = HUGE_VAL;  // of what is wrong, with stomata
  for (result.rounds = 1; result.rounds <= kMostTreeRounds; ++result.rounds) {
    core::pollWork();
    result.flow = tree_.solve(plants, segments_);
    if (!gasLeaves_.empty()) {
      sum = goTowards(result.flow.heads, sum, result.rounds == 1);
      for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t parent = tree_.nodes()[i].parent;
        if (parent != HydraulicTree::kNoParent) {
          const double xylem = 0.5 * (result.flow.heads[i] + result.flow.heads[parent]);
          result.flow.uptakes[i] = 2.0 * (segments_[i].supply - segments_[i].half * xylem);
        }
      }
    }
    Wrong wrong = update(result);
    if (!gasLeaves_.empty()) {
      wrong.flow = sum;
    }
    double all = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      all += std::abs(result.flow.uptakes[i]) + std::abs(result.given[i]);
    }
    const double left = std::max(wrong.flow - wrong.rounding, 0.0);
    error = std::max(left > 0.0 ? left / std::max(all, 1e-300) : 0.0, wrong.vessels);
    if (!std::isfinite(all) || !std::isfinite(error)) {
      break;
    }
    idle = error < 0.5 * least ? 0 : idle + 1;
    least = std::min(least, error);
    // errors of rounding do not become smaller
    if (isLinear || error <= kTolerance || (error <= kRoundingTolerance && idle >= 4)) {
      const double missing = missingWater(result.flow, plants);
      if (missing > kRoundingTolerance * all) {
        error = missing / all;
        break;
      }
      return result;
    }
  }
  segments_.clear();
  return tl::unexpected(error);
}

std::vector<double> PlantWater::changeOf(const Result& solution, const std::vector<double>& soilHeadChanges) const {
  std::vector<double> supplies(soilHeadChanges);
  for (std::size_t i = 0; i < supplies.size(); ++i) {
    supplies[i] *= 0.5 * bySoilHead_[i];
  }
  return tree_.changeOf(solution.flow, segments_, supplies);
}

}  // namespace espalier::environment
