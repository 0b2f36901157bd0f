#include "clients/espalier/roots/root_traits.h"

#include <algorithm>
#include <array>
#include <set>

#include "engine/core/number_text.h"

namespace espalier::roots {

RootTraits traitsOf(const RootSystem& roots, int up) {
  RootTraits traits;
  const auto& nodes = roots.nodes;
  std::set<std::uint32_t> axes;
  std::vector<std::uint32_t> childCount(nodes.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent == RootSystem::kNone) {
      continue;
    }
    const double length = core::length(nodes[i].place - nodes[nodes[i].parent].place);
    RootTraits::Order& order = traits.orders[nodes[i].order];
    order.number += axes.insert(nodes[i].axis).second ? 1 : 0;
    order.length += length;
    // a radius of 0 is one that the file does not give
    order.diameter += length * 2.0 * nodes[i].radius;
    order.lengthWithDiameter += nodes[i].radius > 0.0 ? length : 0.0;
    traits.length += length;
    ++childCount[nodes[i].parent];
  }
  for (auto& [number, order] : traits.orders) {
    order.diameter /= order.lengthWithDiameter > 0.0 ? order.lengthWithDiameter : 1.0;
  }
  std::array<double, 3> low{}, high{};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::array<double, 3> place{nodes[i].place.x, nodes[i].place.y, nodes[i].place.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = i == 0 ? place[axis] : std::min(low[axis], place[axis]);
      high[axis] = i == 0 ? place[axis] : std::max(high[axis], place[axis]);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double& side = static_cast<int>(axis) == up ? traits.height : traits.width;
    side = std::max(side, high[axis] - low[axis]);
  }
  // links from the collar to each node: of k children of a point the first laterals leave at the first of k − 1
  // branching points, and the axis itself passes all of them
  std::vector<std::uint64_t> links(nodes.size(), 0);
  std::vector<std::uint32_t> taken(nodes.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].parent == RootSystem::kNone) {
      continue;
    }
    const RootSystem::Node& parent = nodes[nodes[i].parent];
    const bool isCollar = parent.parent == RootSystem::kNone;
    const std::uint32_t branchings = childCount[nodes[i].parent] - 1;
    const bool isSameAxis = !isCollar && parent.axis == nodes[i].axis;
    const std::uint32_t passed = isSameAxis ? branchings : std::min(++taken[nodes[i].parent], branchings);
    links[i] = links[nodes[i].parent] + passed + (isCollar ? 1 : 0);
    if (childCount[i] == 0) {
      ++traits.magnitude;
      traits.altitude = std::max(traits.altitude, links[i]);
      traits.pathLength += links[i];
    }
  }
  return traits;
}

std::string unitOfLengths(const std::string& unit) {
  return unit.empty() ? "length" : unit;
}

std::string traitTable(const RootTraits& traits, const std::string& unit) {
  constexpr const char* kCount = "1";
  std::string table = "trait\torder\tvalue\tunit\n";
  const auto add = [&](const char* name, const std::string& order, double value, const std::string& of) {
    table += std::string(name) + "\t" + order + "\t";
    core::appendNumber(table, value, core::NumberStyle::Shortest);
    table += "\t" + of + "\n";
  };
  add("length", "", traits.length, unit);
  for (const auto& [number, order] : traits.orders) {
    const std::string name = std::to_string(number);
    add("length", name, order.length, unit);
    add("number", name, static_cast<double>(order.number), kCount);
    add("mean_length", name, order.number > 0 ? order.length / static_cast<double>(order.number) : 0.0, unit);
    if (order.lengthWithDiameter > 0.0) {
      add("diameter", name, order.diameter, unit);
    }
  }
  add("height", "", traits.height, unit);
  add("width", "", traits.width, unit);
  add("magnitude", "", static_cast<double>(traits.magnitude), kCount);
  add("altitude", "", static_cast<double>(traits.altitude), kCount);
  add("path_length", "", static_cast<double>(traits.pathLength), kCount);
  return table;
}

}  // namespace espalier::roots
