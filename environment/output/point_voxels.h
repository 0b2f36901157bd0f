#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/field.h"

namespace espalier::environment {

/// Equal cells of a box along the axes.
struct VoxelBox {
  core::Vec3 position;  // corner with the smallest coordinates
  core::Vec3 cellSize;  // above 0
  std::array<std::size_t, 3> cells{1, 1, 1};
};

/// Points of a scan, in the coordinates of the box.
struct ScannedPoints {
  std::span<const core::Vec3> places;
  std::span<const std::uint8_t> returns;  // echoes of the pulse of each point, at least 1; empty: one each
  std::span<const std::uint8_t> isPlant;  // 1: the point is of a plant; empty: all are
};

/// The points of plants in each cell, `pointCount`. A point on a face belongs to the cell with larger coordinates.
[[nodiscard]] turtle::Field countPoints(const ScannedPoints& points, const VoxelBox& box);

/// The results of pulses from one place for each cell. `pulses`: those that reach it. `gapFraction` P: the part of them
/// that no plant stops there. `leafAreaDensity` in 1/length: −ln P/(G ℓ), with the mean free path ℓ of these pulses
/// through the cell and the projection G of a unit of leaf area (Béland et al., Agricultural and Forest Meteorology
/// 151, 2011). A point of a pulse with n echoes is 1/n of a pulse. A cell that no pulse reaches, or where all end, has
/// no number. Pulses without an echo are in no file, so where many leave the box to the sky P is too small. Voxels are
/// walked as by Amanatides & Woo (Eurographics 1987). O(points · cells along an edge).
[[nodiscard]] std::vector<turtle::Field> tracePulses(const ScannedPoints& points, const VoxelBox& box,
                                                     const core::Vec3& scanner, double projection);

}  // namespace espalier::environment
