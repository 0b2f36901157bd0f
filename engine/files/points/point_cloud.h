#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::files {

/// Most points of one file.
inline constexpr std::uint64_t kMostCloudPoints = 100'000'000;

/// Points that a laser scanner or a camera measured, in the file's own coordinates.
struct PointCloud {
  std::vector<core::Vec3> points;
  std::vector<std::uint8_t> classes;  // of LAS, as 2 ground, 5 high vegetation (points); empty: the file has none
  std::vector<std::uint8_t> returns;  // echoes of the pulse that made the point, at least 1 (points); empty: unknown
  bool isNorthEastUp = false;         // LAS: x to the east, y to the north, z up; else the file does not say
  std::string lengthUnit;             // "m" where the file says metres; empty: it does not say
};

/// A point cloud, or a sentence about the file without its subject ("has 3 of its 5 points. ...").
using PointCloudOrProblem = tl::expected<PointCloud, std::string>;

/// Reads LAS 1.2 to 1.4 (ASPRS LAS Specification 1.4-R15), point formats 0 to 10. Withheld points are left out.
/// Compressed files (LAZ), files cut short, lengths in feet and coordinates in degrees are refused. Time and memory are
/// O(bytes).
[[nodiscard]] PointCloudOrProblem readLasPoints(std::string_view bytes);

/// Reads the vertices of a PLY file (Turk 1994): ascii or binary, in either byte order. Lists of vertices and elements
/// before the vertices are passed over, and elements behind them are not looked at. Time and memory are O(bytes).
[[nodiscard]] PointCloudOrProblem readPlyPoints(std::string_view bytes);

/// Reads either, by the first bytes of the file.
[[nodiscard]] PointCloudOrProblem readPoints(std::string_view bytes);

}  // namespace espalier::files
