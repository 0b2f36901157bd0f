#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/result.h"
#include "engine/core/vec3.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// A point of a tree of lines.
struct TreePoint {
  core::Vec3 position;
  std::uint32_t hopsToLeaf = 0;  // lines on the longest path to a leaf; 0: the point is the end of a leaf
  std::uint32_t branches = 0;    // branches on the path from the root
};

/// A tree as in the text files of Rodrigues, Coelho & Alencar ("Geração de vegetação com L-system", 2018): points 2i
/// and 2i + 1 are the start and the end of line i. The report names the five numbers of a point but not how points form
/// lines. We read from its "retas" between points that two successive points are a line.
struct TreePoints {
  std::vector<TreePoint> points;  // an even number

  /// How high the highest point lies above the lowest; 0 without points.
  [[nodiscard]] double height() const;
  /// The greatest distance of a point from the y axis.
  [[nodiscard]] double radius() const;
};

/// The lines of a scene. Hops are those of a breadth-first search from the leaves. O(segments).
[[nodiscard]] TreePoints treePointsOf(const turtle::Scene& scene);

/// One point a line: x y z, hops to the farthest leaf, branches to the root, separated by blanks.
[[nodiscard]] std::string writeTreePoints(const TreePoints& tree);
/// Reads the text back. Blanks, commas and semicolons separate numbers. A problem names its line.
[[nodiscard]] Result<TreePoints> readTreePoints(std::string_view text);

}  // namespace espalier::command
