#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/vec3.h"
#include "engine/files/colour_files.h"

namespace espalier::files {

/// Most materials, and most corners of all shapes, of one background scene.
inline constexpr std::size_t kMostBackgroundMaterials = 256;
inline constexpr std::size_t kMostBackgroundCorners = 3'000'000;

/// A solid or surface of a background scene, in world coordinates: a sphere, or triangles. The triangles of a prism,
/// cylinder, cone or stretched sphere are closed and share their corners.
struct BackgroundShape {
  bool isSphere = false;
  core::Vec3 centre;                                    // of a sphere
  double radius = 0.0;                                  // of a sphere
  std::vector<core::Vec3> vertices;                     // of triangles
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of vertices
  std::uint32_t material = 0;                           // index into BackgroundScene::materials
};

/// A scene around a plant (docs/model-files.md, 11.4). The turtle does not see it.
struct BackgroundScene {
  std::vector<BackgroundShape> shapes;
  std::vector<Material> materials;  // at least one: the material before any `material`
};

/// A keyword of a background scene that has no effect.
struct BackgroundProblem {
  core::SourceRange range;  // of the keyword in the text
  std::uint32_t line = 1;
  std::string message;  // 'prism' needs 3 numbers, found 2
  bool isUnknown = false;
};

/// Reads a background scene: keywords polygon, polygonuv, mesh, rectangle, prism (box), sphere, cylinder, cone,
/// material, pushmatrix, popmatrix, translate, rotate, scale, multmatrix, each followed by its numbers; comments as in
/// C. Matrices compose as in OpenGL: the newest acts first. Cylinders and cones have 32 sides, as do spheres that a
/// scale makes ellipsoids. A keyword that is unknown or has too few numbers is skipped and added to `problems`.
/// O(text).
[[nodiscard]] BackgroundScene readBackgroundScene(std::string_view text, std::vector<BackgroundProblem>& problems);

}  // namespace espalier::files
