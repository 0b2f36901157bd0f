#include "environment/hydraulics/uptake_fractions.h"

#include <algorithm>
#include <utility>

namespace espalier::environment {

void UptakeFractions::update(std::vector<HydraulicTree::Node> nodes) {
  std::vector<Range> ranges;
  std::vector<double> conductances, fractions;
  fractions.reserve(nodes.size());
  keptPlants_ = 0;
  for (std::size_t first = 0, end = 0; first < nodes.size(); first = end) {
    const std::uint32_t plant = nodes[first].plant;
    end = first + 1;
    while (end < nodes.size() && (nodes[end].parent != HydraulicTree::kNoParent || nodes[end].plant == plant)) {
      ++end;
    }
    const Range now{first, end};
    ranges.resize(std::max<std::size_t>(ranges.size(), plant + 1));
    conductances.resize(ranges.size(), 0.0);
    ranges[plant] = now;
    if (plant < ranges_.size() && isKept(nodes, now, ranges_[plant])) {
      const auto known = fractions_.begin() + static_cast<std::ptrdiff_t>(ranges_[plant].first);
      fractions.insert(fractions.end(), known, known + static_cast<std::ptrdiff_t>(end - first));
      conductances[plant] = conductances_[plant];
      ++keptPlants_;
      continue;
    }
    std::vector<HydraulicTree::Node> own(nodes.begin() + static_cast<std::ptrdiff_t>(first),
                                         nodes.begin() + static_cast<std::ptrdiff_t>(end));
    for (HydraulicTree::Node& node : own) {
      node.parent -= node.parent == HydraulicTree::kNoParent ? 0 : static_cast<std::uint32_t>(first);
      node.plant = 0;
    }
    const HydraulicTree::Result result = HydraulicTree(std::move(own)).solve(HydraulicTree::Collar{});
    fractions.insert(fractions.end(), result.uptakeFractions.begin(), result.uptakeFractions.end());
    conductances[plant] = result.conductances.front();
  }
  nodes_ = std::move(nodes);
  ranges_ = std::move(ranges);
  conductances_ = std::move(conductances);
  fractions_ = std::move(fractions);
}

/// Whether everything is equal that conductance and fractions depend on.
bool UptakeFractions::isKept(const std::vector<HydraulicTree::Node>& nodes, const Range& now,
                             const Range& before) const {
  if (now.end - now.first != before.end - before.first) {
    return false;
  }
  for (std::size_t i = 0; i < now.end - now.first; ++i) {
    const HydraulicTree::Node& one = nodes[now.first + i];
    const HydraulicTree::Node& other = nodes_[before.first + i];
    const bool isCollar = one.parent == HydraulicTree::kNoParent;
    if (isCollar != (other.parent == HydraulicTree::kNoParent) ||
        (!isCollar && one.parent - now.first != other.parent - before.first) || one.length != other.length ||
        one.radius != other.radius || one.axialConductance != other.axialConductance ||
        one.radialConductivity != other.radialConductivity || one.demandByHead != other.demandByHead) {
      return false;
    }
  }
  return true;
}

}  // namespace espalier::environment
