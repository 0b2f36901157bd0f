#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "clients/espalier/validation/reference_table.h"
#include "environment/hydraulics/conductivities.h"
#include "environment/hydraulics/hydraulic_tree.h"

namespace espalier::validation {

/// The nodes of a published root system.
struct RootTable {
  ReferenceTable nodes;     // node, parent, x, y, z, radius, order, emergence
  bool isPublished = true;  // false: from RSML, which has one kind of joins and no heads
  bool hasDays = true;      // false: from RSML without the function `emergence_time`
};

/// `NAME.tsv` of the data, or else `NAME.rsml` in the Root System Markup Language, in cm with z up. Nothing when both
/// are missing. Throws TableError for a file that cannot be read, or whose lengths or directions are not known.
[[nodiscard]] std::optional<RootTable> readRootTable(const Data& data, const std::string& name,
                                                     std::vector<std::string>& missing);

/// The properties of segments in a table of roots beside their places.
struct RootProperties {
  double kx = 0.0;  // unless by age
  double kr = 0.0;
  double soilHead = 0.0;
  const ReferenceTable* ages = nullptr;  // conductivities by order and age; null: none
  double day = 0.0;                      // of the roots: the age of a segment is the time since it emerged
};

/// The rows of order, age and value of a table of conductivities.
[[nodiscard]] environment::ConfigurationRows rowsOf(const ReferenceTable& ages, const std::string& column);

/// The parent of a node, by the column that has the parents; nothing for a collar. Throws TableError when the parent is
/// not an earlier node, as in a cycle or of an orphan.
[[nodiscard]] std::optional<std::size_t> parentOf(const ReferenceTable& roots, std::size_t row,
                                                  const std::string& column);

/// The tree of a table of nodes: x, y, z (up), radius, order, emergence, and the column that has the parents.
[[nodiscard]] environment::HydraulicTree treeOf(const ReferenceTable& roots, const std::string& parents,
                                                const RootProperties& properties);

}  // namespace espalier::validation
