#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/files/view_settings.h"

namespace espalier::language {

/// Bound of what is read from one mesh file, the instances of its scene counted.
inline constexpr std::size_t kMostMeshTriangles = 1'000'000;

/// Whether a file's name says that it holds a mesh that readMeshFile understands: `.obj`, `.glb` or `.gltf`.
[[nodiscard]] bool isMeshFile(std::string_view name);

/// Reads the triangles of a mesh made by another program, in the file's own coordinates: Wavefront OBJ (polygons are
/// cut into triangles), or glTF 2.0, binary or as text with its data inside, with the transformations of its scene.
/// Colours, materials, textures, bones and animations are not looked at. A corner without a normal gets that of its
/// triangle. Texture coordinates have v upward. Anything wrong gives a sentence that says what. Reads no other files.
[[nodiscard]] std::variant<std::vector<SurfaceTriangle>, std::string> readMeshFile(std::string_view name,
                                                                                   const std::string& bytes);

/// The same for one format.
[[nodiscard]] std::variant<std::vector<SurfaceTriangle>, std::string> readObjMesh(const std::string& text);
[[nodiscard]] std::variant<std::vector<SurfaceTriangle>, std::string> readGltfMesh(const std::string& bytes);

/// The corners of a triangle as a file has them, and what follows where the file leaves normals out.
struct MeshCorner {
  core::Vec3 position;
  std::optional<core::Vec3> normal;
  std::array<double, 2> coordinates{};
};
[[nodiscard]] SurfaceTriangle triangleOf(const std::array<MeshCorner, 3>& corners);

}  // namespace espalier::language
