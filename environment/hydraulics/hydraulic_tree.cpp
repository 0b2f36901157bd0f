#include "environment/hydraulics/hydraulic_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

/// The flow in a segment by the heads of its ends (upper: towards the collar) against the soil, towards the collar:
/// at the lower end through·(lower − upper) + half·lower, at the upper end through·(lower − upper) − half·upper.
struct Conductances {
  double through = 0.0;  // kx τ / sinh τl
  double half = 0.0;     // kx τ tanh(τl/2): what enters through the surface by the mean of both ends
};

Conductances conductancesOf(const HydraulicTree::Node& node) {
  const double tau = std::sqrt(2.0 * std::numbers::pi * node.radius * node.radialConductivity / node.axialConductance);
  const double x = tau * node.length;
  if (x < 1e-8) {
    return {node.axialConductance / node.length, 0.5 * node.axialConductance * tau * x};
  }
  // sinh x = (e + e/(e + 1))/2 and tanh(x/2) = e/(e + 2), with e = exp(x) − 1, which keeps all figures of a small x
  const double e = core::expm1(std::min(x, 700.0));
  return {2.0 * node.axialConductance * tau / (e + e / (e + 1.0)), node.axialConductance * tau * e / (e + 2.0)};
}

/// The flow into each node from below as base + slope · head of the node.
struct Below {
  std::vector<double> base, slope;
};

}  // namespace

std::vector<std::uint32_t> HydraulicTree::plantOf() const {
  std::vector<std::uint32_t> plant(nodes_.size());
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    plant[node] = nodes_[node].parent == kNoParent ? nodes_[node].plant : plant[nodes_[node].parent];
  }
  return plant;
}

std::vector<double> HydraulicTree::collarHeads(std::span<const Collar> plants, const std::vector<double>& base,
                                               const std::vector<double>& slope) const {
  std::vector<double> flows, slopes;  // out of all collars of each plant at head 0, and how they grow with the head
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].parent == kNoParent) {
      flows.resize(std::max<std::size_t>(flows.size(), nodes_[i].plant + 1), 0.0);
      slopes.resize(flows.size(), 0.0);
      flows[nodes_[i].plant] += base[i] - nodes_[i].demand;
      slopes[nodes_[i].plant] += slope[i] - nodes_[i].demandByHead;
    }
  }
  std::vector<double> heads;
  for (std::size_t plant = 0; plant < flows.size(); ++plant) {
    const Collar& collar = plants[plants.size() == 1 ? 0 : plant];
    double head = collar.head;
    if (!collar.hasHead) {
      // a plant without any way for water in or out of the soil keeps the lowest head
      head = slopes[plant] < 0.0 ? (collar.flow - flows[plant]) / slopes[plant] : collar.lowestHead;
      head = std::max(head, collar.lowestHead);
    }
    heads.push_back(head);
  }
  return heads;
}

HydraulicTree::Result HydraulicTree::solve(std::span<const Collar> plants) const {
  const std::size_t count = nodes_.size();
  std::vector<Conductances> conductances(count);
  Below below{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  for (std::size_t i = 0; i < count; ++i) {
    if (nodes_[i].parent != kNoParent) {
      conductances[i] = conductancesOf(nodes_[i]);
    }
  }
  // from the tips to the collars: what a node passes on is linear in the head of its parent
  for (std::size_t i = count; i-- > 0;) {
    const Node& node = nodes_[i];
    if (node.parent == kNoParent) {
      continue;
    }
    const auto [through, half] = conductances[i];
    const double gravity = node.axialConductance * node.rise / node.length;
    const double leaving =
        node.demandByHead - below.slope[i];  // how what leaves this node downwards grows with its head
    const double own = through + half;       // how the flow at an end grows with the head of that end
    const double pivot = own + leaving;
    // head = (known + through · parent head)/pivot, known = base − demand + half · soil head − gravity; the flow at the
    // upper end follows, written in terms of one sign, so that nothing cancels in wide vessels
    const double share = through / pivot;
    below.base[node.parent] += share * (below.base[i] - node.demand) + half * node.soilHead * (1.0 + share) +
                               gravity * (half + leaving) / pivot;
    below.slope[node.parent] -= (half * (2.0 * through + half) + own * leaving) / pivot;
  }
  Result result;
  result.heads.assign(count, 0.0);
  result.uptakes.assign(count, 0.0);
  result.uptakeFractions.assign(count, 0.0);
  std::vector<double> unit(count, 0.0);  // heads against a soil at total head 0, when the collar is at −1
  const std::vector<std::uint32_t> plantOf = this->plantOf();
  const std::vector<double> collars = collarHeads(plants, below.base, below.slope);
  std::vector<double> entered(collars.size(), 0.0);  // uptake of a plant in that case
  result.collarFlows.assign(collars.size(), 0.0);
  result.conductances.assign(collars.size(), 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Node& node = nodes_[i];
    if (node.parent == kNoParent) {
      const double head = collars[node.plant];
      result.heads[i] = head;
      result.collarFlows[node.plant] += below.base[i] + below.slope[i] * head - node.demand - node.demandByHead * head;
      result.conductances[node.plant] -= below.slope[i];
      unit[i] = -1.0;
      continue;
    }
    const auto [through, half] = conductances[i];
    const double gravity = node.axialConductance * node.rise / node.length;
    const double pivot = through + half - below.slope[i] + node.demandByHead;
    const double upper = result.heads[node.parent];
    result.heads[i] = (below.base[i] - node.demand + half * node.soilHead - gravity + through * upper) / pivot;
    result.uptakes[i] = half * (2.0 * node.soilHead - upper - result.heads[i]);
    unit[i] = through * unit[node.parent] / pivot;
    result.uptakeFractions[i] = -half * (unit[node.parent] + unit[i]);
    entered[plantOf[i]] += result.uptakeFractions[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double all = entered[plantOf[i]];
    result.uptakeFractions[i] = all > 0.0 ? result.uptakeFractions[i] / all : 0.0;
  }
  return result;
}

}  // namespace espalier::environment
