#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/files/view_settings.h"

namespace espalier::files {

/// Most triangles of one mesh file, with all instances of its scene.
inline constexpr std::size_t kMostMeshTriangles = 1'000'000;

/// Whether a file's name has a suffix of a mesh format: `.obj`, `.glb` or `.gltf`.
[[nodiscard]] bool isMeshFile(std::string_view name);

/// The triangles of a mesh, or a sentence about the file ("it has no triangles").
using MeshTriangles = tl::expected<std::vector<SurfaceTriangle>, std::string>;

/// Reads the triangles of a mesh made by another program, in the file's own coordinates. Wavefront OBJ: polygons are
/// cut into triangles. glTF 2.0, binary or text with its data inside: the transformations of the scene are applied.
/// Colours, materials, textures, bones and animations are ignored. A corner without a normal gets the normal of its
/// triangle. Texture coordinates have v upward. No other file is read.
[[nodiscard]] MeshTriangles readMeshFile(std::string_view name, const std::string& bytes);

/// The same for one format.
[[nodiscard]] MeshTriangles readObjMesh(const std::string& text);
[[nodiscard]] MeshTriangles readGltfMesh(const std::string& bytes);

/// A corner of a triangle as the file has it; triangleOf supplies a missing normal.
struct MeshCorner {
  core::Vec3 position;
  std::optional<core::Vec3> normal;
  std::array<double, 2> coordinates{};
};
[[nodiscard]] SurfaceTriangle triangleOf(const std::array<MeshCorner, 3>& corners);

}  // namespace espalier::files
