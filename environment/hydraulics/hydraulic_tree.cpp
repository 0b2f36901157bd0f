#include "environment/hydraulics/hydraulic_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

/// A head far below all others.
constexpr double kFarBelow = -1e12;

}  // namespace

HydraulicTree::Segment HydraulicTree::segmentOf(const Node& node) {
  Segment segment{.demand = node.demand, .demandByHead = node.demandByHead};
  if (node.parent == kNoParent) {
    return segment;
  }
  // through = kx τ / sinh τl, half = kx τ tanh(τl/2)
  const double tau = std::sqrt(2.0 * std::numbers::pi * node.radius * node.radialConductivity / node.axialConductance);
  const double x = tau * node.length;
  if (x < 1e-8) {
    segment.through = node.axialConductance / node.length;
    segment.half = 0.5 * node.axialConductance * tau * x;
  } else {
    // sinh x = (e + e/(e + 1))/2 and tanh(x/2) = e/(e + 2), with e = exp(x) − 1, which keeps all figures of a small x
    const double e = core::expm1(std::min(x, 700.0));
    segment.through = 2.0 * node.axialConductance * tau / (e + e / (e + 1.0));
    segment.half = node.axialConductance * tau * e / (e + 2.0);
  }
  segment.supply = segment.half * node.soilHead;
  segment.gravity = node.axialConductance * node.rise / node.length;
  return segment;
}

std::vector<HydraulicTree::Segment> HydraulicTree::segments() const {
  std::vector<Segment> segments;
  segments.reserve(nodes_.size());
  for (const Node& node : nodes_) {
    segments.push_back(segmentOf(node));
  }
  return segments;
}

std::vector<std::uint32_t> HydraulicTree::plantOf() const {
  std::vector<std::uint32_t> plant(nodes_.size());
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    plant[node] = nodes_[node].parent == kNoParent ? nodes_[node].plant : plant[nodes_[node].parent];
  }
  return plant;
}

HydraulicTree::Elimination HydraulicTree::eliminate(const std::vector<Segment>& segments) const {
  Elimination result{std::vector<double>(nodes_.size(), 0.0), std::vector<double>(nodes_.size(), 0.0)};
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const auto& [through, half, supply, gravity, demand, demandByHead] = segments[i];
    if (nodes_[i].parent == kNoParent) {
      continue;
    }
    const double leaving = demandByHead - result.slope[i];  // how what leaves downwards grows with the node's head
    const double own = through + half;                      // how the flow at an end grows with the head of that end
    result.pivot[i] = own + leaving;
    // written in terms of one sign, so that nothing cancels in wide vessels
    result.slope[nodes_[i].parent] -= (half * (2.0 * through + half) + own * leaving) / result.pivot[i];
  }
  return result;
}

std::vector<double> HydraulicTree::sumOfCollars(const std::vector<double>& values) const {
  std::vector<double> sums;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].parent == kNoParent) {
      sums.resize(std::max<std::size_t>(sums.size(), nodes_[i].plant + 1), 0.0);
      sums[nodes_[i].plant] += values[i];
    }
  }
  return sums;
}

HydraulicTree::Result HydraulicTree::solve(std::span<const Collar> plants) const {
  const std::vector<Segment> segments = this->segments();
  const Elimination elimination = eliminate(segments);
  Result result = solve(plants, segments, elimination);
  addConductances(segments, elimination, result);
  return result;
}

HydraulicTree::Result HydraulicTree::solve(std::span<const Collar> plants, const std::vector<Segment>& segments) const {
  return solve(plants, segments, eliminate(segments));
}

HydraulicTree::Result HydraulicTree::solve(std::span<const Collar> plants, const std::vector<Segment>& segments,
                                           const Elimination& elimination) const {
  const std::size_t count = nodes_.size();
  std::vector<double> base(count, 0.0);  // flow into each node from below at head 0
  for (std::size_t i = count; i-- > 0;) {
    const Segment& segment = segments[i];
    if (nodes_[i].parent != kNoParent) {
      const double share = segment.through / elimination.pivot[i];
      const double leaving = segment.demandByHead - elimination.slope[i];
      base[nodes_[i].parent] += share * (base[i] - segment.demand) + segment.supply * (1.0 + share) +
                                segment.gravity * (segment.half + leaving) / elimination.pivot[i];
    }
  }
  // out of all collars of each plant at head 0, and how it grows with the head
  std::vector<double> flow(count, 0.0), slope(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    flow[i] = base[i] - segments[i].demand;
    slope[i] = elimination.slope[i] - segments[i].demandByHead;
  }
  Result result;
  result.collarFlows = sumOfCollars(flow);
  const std::vector<double> slopes = sumOfCollars(slope);
  std::vector<double> collarHeads;
  for (std::size_t plant = 0; plant < slopes.size(); ++plant) {
    const Collar& collar = plants[plants.size() == 1 ? 0 : plant];
    double head = collar.head;
    bool isFlowGiven = !collar.hasHead;
    if (isFlowGiven) {
      // a plant without any way for water in or out of the soil keeps the lowest head
      head = slopes[plant] < 0.0 ? (collar.flow - result.collarFlows[plant]) / slopes[plant] : collar.lowestHead;
      // a collar that gives nothing off has no lowest head: water does not enter there
      const double lowest = collar.flow > 0.0 || !(slopes[plant] < 0.0) ? collar.lowestHead : kFarBelow;
      isFlowGiven = head > lowest;
      head = std::max(head, lowest);
      if (!isFlowGiven && collar.flow > 0.0 && result.collarFlows[plant] + slopes[plant] * head < 0.0) {
        // soil and leaves are drier than the lowest head: nothing goes out, and no water comes in from outside
        head = -result.collarFlows[plant] / slopes[plant];
        isFlowGiven = true;
      }
    }
    collarHeads.push_back(head);
    result.isFlowGiven.push_back(isFlowGiven ? 1 : 0);
    result.collarFlows[plant] += slopes[plant] * head;
  }
  // from the collars to the tips
  result.heads.assign(count, 0.0);
  result.uptakes.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Segment& segment = segments[i];
    if (nodes_[i].parent == kNoParent) {
      result.heads[i] = collarHeads[nodes_[i].plant];
      continue;
    }
    const double upper = result.heads[nodes_[i].parent];
    result.heads[i] =
        (base[i] - segment.demand + segment.supply - segment.gravity + segment.through * upper) / elimination.pivot[i];
    result.uptakes[i] = 2.0 * segment.supply - segment.half * (upper + result.heads[i]);
  }
  return result;
}

void HydraulicTree::addConductances(const std::vector<Segment>& segments, const Elimination& elimination,
                                    Result& result) const {
  const std::size_t count = nodes_.size();
  result.conductances = sumOfCollars(elimination.slope);
  for (double& conductance : result.conductances) {
    conductance = -conductance;
  }
  result.uptakeFractions.assign(count, 0.0);
  const std::vector<std::uint32_t> plantOf = this->plantOf();
  std::vector<double> unit(count, 0.0);  // heads against a soil at total head 0, when the collar is at −1
  std::vector<double> entered(result.conductances.size(), 0.0);  // uptake of a plant in that case
  for (std::size_t i = 0; i < count; ++i) {
    if (nodes_[i].parent == kNoParent) {
      unit[i] = -1.0;
      continue;
    }
    unit[i] = segments[i].through * unit[nodes_[i].parent] / elimination.pivot[i];
    result.uptakeFractions[i] = -segments[i].half * (unit[nodes_[i].parent] + unit[i]);
    entered[plantOf[i]] += result.uptakeFractions[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double all = entered[plantOf[i]];
    result.uptakeFractions[i] = all > 0.0 ? result.uptakeFractions[i] / all : 0.0;
  }
}

std::vector<double> HydraulicTree::changeOf(const Result& solution, const std::vector<Segment>& segments,
                                            const std::vector<double>& supplyChanges) const {
  const std::size_t count = nodes_.size();
  const Elimination elimination = eliminate(segments);
  std::vector<double> base(count, 0.0), slope(count, 0.0);
  for (std::size_t i = count; i-- > 0;) {
    slope[i] = elimination.slope[i] - segments[i].demandByHead;
    if (nodes_[i].parent != kNoParent) {
      const double share = segments[i].through / elimination.pivot[i];
      base[nodes_[i].parent] += share * base[i] + supplyChanges[i] * (1.0 + share);
    }
  }
  const std::vector<double> flows = sumOfCollars(base);
  const std::vector<double> slopes = sumOfCollars(slope);
  std::vector<double> heads(count, 0.0), changes(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (nodes_[i].parent == kNoParent) {
      const std::uint32_t plant = nodes_[i].plant;
      heads[i] = solution.isFlowGiven[plant] != 0 && slopes[plant] < 0.0 ? -flows[plant] / slopes[plant] : 0.0;
      continue;
    }
    const double upper = heads[nodes_[i].parent];
    heads[i] = (base[i] + supplyChanges[i] + segments[i].through * upper) / elimination.pivot[i];
    changes[i] = 2.0 * supplyChanges[i] - segments[i].half * (upper + heads[i]);
  }
  return changes;
}

}  // namespace espalier::environment
