#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "engine/turtle/scene/geometry.h"
#include "environment/light/rays/leaf_light.h"

namespace espalier::environment {

/// The triangles of all plants, with what drew them.
struct PlantSurfaces {
  LightSurfaces surfaces;  // material: the colour's number for organs, that plus kSegment for segments
  static constexpr std::uint32_t kSegment = 256;
  /// Plant and module that drew each triangle.
  std::vector<std::pair<std::uint32_t, std::uint64_t>> sources;
  std::vector<std::uint32_t> bySource;  // triangles sorted by source, then number

  /// The triangles drawn by a module, ascending.
  [[nodiscard]] std::pair<std::size_t, std::size_t> rangeOf(std::uint32_t plant, std::uint64_t module) const;
};

/// Organs are taken as they are; segments become open prisms of `sides` sides with the segment's area of a cone, and
/// are left out when their widths are pixels or 0. The rays of an organ go with its place: thinned by the number of its
/// triangles, each looking elsewhere. O(n log n).
[[nodiscard]] PlantSurfaces surfacesOf(const turtle::Geometry& geometry, int sides);

}  // namespace espalier::environment
