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

std::vector<std::uint32_t> HydraulicTree::collars() const {
  std::vector<std::uint32_t> found;
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    if (nodes_[node].parent == kNoParent) {
      found.push_back(node);
    }
  }
  return found;
}

std::vector<std::uint32_t> HydraulicTree::collarOf() const {
  std::vector<std::uint32_t> collar(nodes_.size());
  std::uint32_t count = 0;
  for (std::uint32_t node = 0; node < nodes_.size(); ++node) {
    collar[node] = nodes_[node].parent == kNoParent ? count++ : collar[nodes_[node].parent];
  }
  return collar;
}

HydraulicTree::Result HydraulicTree::solve(const Collar& collar) const {
  const std::size_t count = nodes_.size();
  std::vector<Conductances> conductances(count);
  Below below{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
  // total heads: at the collar 0, below it less what lies above; soil at total head 0 for the uptake fractions
  std::vector<double> heights(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    if (nodes_[i].parent != kNoParent) {
      conductances[i] = conductancesOf(nodes_[i]);
      heights[i] = heights[nodes_[i].parent] + nodes_[i].rise;
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
    const double own = through + half;  // how the flow at an end grows with the head of that end
    const double pivot = own - below.slope[i];
    const double known = below.base[i] - node.demand + half * node.soilHead - gravity;
    // head = (known + through · parent head)/pivot; the flow at the upper end follows
    below.base[node.parent] += through * known / pivot + half * node.soilHead + gravity;
    below.slope[node.parent] += through * through / pivot - own;
  }
  Result result;
  result.heads.assign(count, 0.0);
  result.uptakes.assign(count, 0.0);
  result.uptakeFractions.assign(count, 0.0);
  std::vector<double> unit(count, 0.0);  // heads against a soil at total head 0, when the collar is at −1
  std::vector<double> entered;           // uptake of a tree in that case
  const std::vector<std::uint32_t> treeOf = collarOf();
  for (std::size_t i = 0; i < count; ++i) {
    const Node& node = nodes_[i];
    if (node.parent == kNoParent) {
      double head = collar.head;
      if (!collar.hasHead) {
        // a plant without any way for water in or out of the soil keeps the lowest head
        const double slope = below.slope[i];
        head = slope < 0.0 ? (collar.flow + node.demand - below.base[i]) / slope : collar.lowestHead;
        head = std::max(head, collar.lowestHead);
      }
      result.heads[i] = head;
      result.collarFlows.push_back(below.base[i] + below.slope[i] * head - node.demand);
      result.conductances.push_back(-below.slope[i]);
      unit[i] = -1.0;
      entered.push_back(0.0);
      continue;
    }
    const auto [through, half] = conductances[i];
    const double gravity = node.axialConductance * node.rise / node.length;
    const double pivot = through + half - below.slope[i];
    const double upper = result.heads[node.parent];
    result.heads[i] = (below.base[i] - node.demand + half * node.soilHead - gravity + through * upper) / pivot;
    result.uptakes[i] = half * (2.0 * node.soilHead - upper - result.heads[i]);
    unit[i] = through * unit[node.parent] / pivot;
    result.uptakeFractions[i] = -half * (unit[node.parent] + unit[i]);
    entered[treeOf[i]] += result.uptakeFractions[i];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double all = entered[treeOf[i]];
    result.uptakeFractions[i] = all > 0.0 ? result.uptakeFractions[i] / all : 0.0;
  }
  return result;
}

}  // namespace espalier::environment
