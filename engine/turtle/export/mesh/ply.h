#pragma once

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// Writes a binary little-endian PLY 1.0. A vertex has position, normal, texture coordinates `s t`, colour, and where
/// it comes from: `plant`, `module` (index in the plant's string), `order` (of the branch) and `organ` (the number of
/// an OrganKind); comments of the header list symbols and organs. A face has its corners and its `module`. Vertices of
/// a tube belong to the segment that ends at their ring. Makes each mesh three times: to count, for vertices, for
/// faces.
[[nodiscard]] std::optional<std::string> exportPly(const PlacedScenes& placed, const ExportTarget& target);

}  // namespace espalier::turtle
