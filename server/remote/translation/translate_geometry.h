#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/turtle/scene/geometry.h"
#include "protocol/geometry.h"

namespace espalier::server {

// Geometry between the engine and the protocol; with translate.h and translate_environment.h the only crossing.

/// The columns of a geometry, or with `before` of the difference from that one. They refer to it, except for converted
/// columns. `symbols` are the names by SymbolId. O(rows + vertices).
[[nodiscard]] protocol::GeometryColumns toColumns(std::shared_ptr<const turtle::Geometry> geometry,
                                                  const turtle::Geometry* before,
                                                  const std::vector<std::string>& symbols);

/// The geometry of such columns; names that `symbols` lacks are appended to it. `before` is the one that a difference
/// is from; null: there is none. An error sentence when the difference is not one of it.
[[nodiscard]] std::optional<std::string> toGeometry(const protocol::GeometryColumns& columns,
                                                    const turtle::Geometry* before, std::vector<std::string>& symbols,
                                                    turtle::Geometry& geometry);

/// The ids of names among `symbols`, to which those it lacks are appended.
[[nodiscard]] std::vector<core::SymbolId> idsOf(const std::vector<std::string>& names,
                                                std::vector<std::string>& symbols);

}  // namespace espalier::server
