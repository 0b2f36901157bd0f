#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::environment {

/// Triangles that take, reflect and let pass light.
struct LightSurfaces {
  std::vector<core::Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> material;  // of each triangle
  /// Chooses the points on a triangle and the lattice of directions in which it looks (triangles; empty: its number). A
  /// number that belongs to the organ, not to its row of the table, lets rays be kept when organs come before it.
  std::vector<std::uint32_t> seed;
  std::vector<std::uint8_t> thinning;  // of its directions, see RayDirections (triangles; empty: 0)
  /// First of the triangles of a ground under all plants. They are the last ones, and few for the light on them.
  std::size_t groundBegin = std::numeric_limits<std::size_t>::max();

  [[nodiscard]] std::uint32_t seedOf(std::uint32_t triangle) const { return seed.empty() ? triangle : seed[triangle]; }
  [[nodiscard]] unsigned thinningOf(std::uint32_t triangle) const { return thinning.empty() ? 0U : thinning[triangle]; }
};

/// Which triangles of a scene were in an earlier one too, with the same corners, seed and thinning.
struct SurfaceChanges {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> earlierOf;  // number in the earlier scene; kNone: it is new (triangles)
  std::vector<std::uint32_t> laterOf;    // kNone: it is gone (earlier triangles)
  LightSurfaces changed;                 // the new and the gone ones; corners only

  [[nodiscard]] bool isEmpty() const { return changed.triangles.empty(); }
};

/// Triangles that were there before keep their order: one that moved in front of others counts as gone and new. O(n)
/// when few changed, else O(n log n).
[[nodiscard]] SurfaceChanges changesBetween(const LightSurfaces& earlier, const LightSurfaces& later);

}  // namespace espalier::environment
