#include "clients/espalier/validation/root_tables.h"

#include <cmath>

namespace espalier::validation {

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
      const double age = properties.day - roots.number(i, "emergence");
      node.axialConductance = axial.at(order, age);
      node.radialConductivity = radial.at(order, age);
      node.soilHead = properties.soilHead;
    }
    nodes.push_back(node);
  }
  return environment::HydraulicTree(std::move(nodes));
}

}  // namespace espalier::validation
