#include "clients/espalier/validation/root_tables.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "clients/espalier/roots/root_system.h"
#include "environment/base/number_text.h"

namespace espalier::validation {

namespace {

/// The rows of a root system in cm. The collar of the benchmarks is the point (0, 0, 0): the published files leave out
/// the first points of the main root, and a straight piece takes their place.
std::vector<std::vector<std::string>> rowsOf(const roots::RootSystem& system) {
  using environment::numberText;
  constexpr double kNear = 1.0;  // cm
  std::vector<std::vector<std::string>> rows;
  const auto isBelowCollar = [](const roots::RootSystem::Node& node) {
    return node.parent == roots::RootSystem::kNone && node.place.z < 0.0 && core::length(node.place) < kNear;
  };
  const bool hasCollar = std::ranges::none_of(system.nodes, isBelowCollar);
  const std::uint32_t added = hasCollar ? 0 : 1;
  if (!hasCollar) {
    rows.push_back({"0", "-1", "0", "0", "0", "0", "1", ""});
  }
  for (const roots::RootSystem::Node& node : system.nodes) {
    const bool isCollar = node.parent == roots::RootSystem::kNone;
    const std::string parent = isBelowCollar(node) ? "0" : isCollar ? "-1" : std::to_string(node.parent + added);
    rows.push_back({std::to_string(rows.size()), parent, numberText(node.place.x), numberText(node.place.y),
                    numberText(node.place.z), numberText(node.radius), std::to_string(node.order),
                    std::isnan(node.emergence) ? "" : numberText(node.emergence)});
  }
  return rows;
}

/// Why a root system is none of a benchmark; nothing: it is one.
std::optional<std::string> problemOf(const roots::RootSystem& system) {
  double depth = 0.0;
  for (const roots::RootSystem::Node& node : system.nodes) {
    if (node.parent != roots::RootSystem::kNone) {
      depth -= node.place.z - system.nodes[node.parent].place.z;
      if (!(node.radius > 0.0)) {
        return "its roots have no diameter. Give each root the function 'diameter'";
      }
    }
  }
  if (system.unit.empty()) {
    return "it does not say the unit of its lengths. Write <unit>cm</unit> in its metadata";
  }
  return depth > 0.0 ? std::nullopt
                     : std::optional<std::string>(
                           "its roots do not grow down. The benchmarks measure z upwards: write depths as negative z");
}

}  // namespace

std::optional<RootTable> readRootTable(const Data& data, const std::string& name, std::vector<std::string>& missing) {
  const std::string markup = name + ".rsml";
  const auto text = data(markup);
  if (!text || data(name + ".tsv")) {
    std::vector<std::string> notThere;
    auto table = ReferenceTable::read(data, name + ".tsv", notThere);
    if (!table) {
      missing.push_back(name + ".tsv or " + markup);
      return std::nullopt;
    }
    return RootTable{std::move(*table), true, true};
  }
  auto system = roots::readRsml(*text);
  if (!system) {
    throw TableError(markup + ", " + system.error());
  }
  auto problem = roots::convertTo(*system, "cm");
  problem = problem ? problem : problemOf(*system);
  if (problem) {
    throw TableError(markup + ": " + *problem);
  }
  return RootTable{
      ReferenceTable::of(markup, "point", {"node", "parent", "x", "y", "z", "radius", "order", "emergence"},
                         rowsOf(*system)),
      false, std::ranges::none_of(system->nodes, [](const auto& node) { return std::isnan(node.emergence); })};
}

environment::ConfigurationRows rowsOf(const ReferenceTable& ages, const std::string& column) {
  environment::ConfigurationRows rows;
  for (std::size_t row = 0; row < ages.rowCount(); ++row) {
    rows.push_back({ages.number(row, "order"), ages.number(row, "age"), ages.number(row, column)});
  }
  return rows;
}

std::optional<std::size_t> parentOf(const ReferenceTable& roots, std::size_t row, const std::string& column) {
  const double parent = roots.number(row, column);
  if (parent >= static_cast<double>(row) || parent != std::floor(parent)) {
    roots.refuse(row, "the node " + std::to_string(row) + " has the parent " + roots.text(row, column) +
                          ". Nodes count from 0, and a parent comes before its children: write an earlier node, or -1 "
                          "for a collar");
  }
  return parent >= 0.0 ? std::optional(static_cast<std::size_t>(parent)) : std::nullopt;
}

environment::HydraulicTree treeOf(const ReferenceTable& roots, const std::string& parents,
                                  const RootProperties& properties) {
  const bool hasAges = properties.ages != nullptr;
  const environment::ConductivityTable axial(
      properties.kx, hasAges ? rowsOf(*properties.ages, "kx") : environment::ConfigurationRows());
  const environment::ConductivityTable radial(
      properties.kr, hasAges ? rowsOf(*properties.ages, "kr") : environment::ConfigurationRows());
  std::vector<environment::HydraulicTree::Node> nodes;
  for (std::size_t i = 0; i < roots.rowCount(); ++i) {
    environment::HydraulicTree::Node node;
    if (const auto parent = parentOf(roots, i, parents)) {
      node.parent = static_cast<std::uint32_t>(*parent);
      const auto way = [&](const char* axis) { return roots.number(i, axis) - roots.number(node.parent, axis); };
      node.length = std::hypot(way("x"), way("y"), way("z"));
      node.rise = way("z");
      node.radius = roots.number(i, "radius");
      const double order = roots.number(i, "order");
      const double age = hasAges ? properties.day - roots.number(i, "emergence") : 0.0;
      node.axialConductance = axial.at(order, age);
      node.radialConductivity = radial.at(order, age);
      node.soilHead = properties.soilHead;
    }
    nodes.push_back(node);
  }
  return environment::HydraulicTree(std::move(nodes));
}

}  // namespace espalier::validation
