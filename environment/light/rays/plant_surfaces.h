#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "engine/turtle/scene/geometry.h"
#include "environment/light/rays/leaf_light.h"

namespace espalier::environment {

/// The triangles of all plants, with the modules that drew them.
struct PlantSurfaces {
  LightSurfaces surfaces;  // material: the colour's number for organs, that plus kSegment for segments
  static constexpr std::uint32_t kSegment = 256;
  /// Plant and module that drew each triangle.
  std::vector<std::pair<std::uint32_t, std::uint64_t>> sources;
  std::vector<std::uint32_t> bySource;  // triangles sorted by source, then number

  /// The triangles drawn by a module, ascending.
  [[nodiscard]] std::pair<std::size_t, std::size_t> rangeOf(std::uint32_t plant, std::uint64_t module) const;
};

/// Organs keep their triangles. Segments become open prisms of `sides` sides with the area of the segment's cone;
/// segments with widths of 0 or in pixels are left out. The rays of an organ follow from its place: the number of its
/// triangles thins them, and its triangles look in different directions. O(n log n).
[[nodiscard]] PlantSurfaces surfacesOf(const turtle::Geometry& geometry, int sides);

}  // namespace espalier::environment
