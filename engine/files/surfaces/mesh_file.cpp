#include "engine/files/surfaces/mesh_file.h"

#include "engine/files/file_name.h"

namespace espalier::files {

bool isMeshFile(std::string_view name) {
  return endsIn(name, ".obj") || endsIn(name, ".glb") || endsIn(name, ".gltf");
}

SurfaceTriangle triangleOf(const std::array<MeshCorner, 3>& corners) {
  SurfaceTriangle triangle;
  const core::Vec3 side = core::normalised(
      core::cross(corners[1].position - corners[0].position, corners[2].position - corners[0].position));
  for (std::size_t k = 0; k < 3; ++k) {
    const core::Vec3 normal = core::normalised(corners[k].normal.value_or(side));
    triangle.points[k] = corners[k].position;
    triangle.normals[k] = core::length(normal) > 0.0 ? normal : side;
    triangle.coordinates[k] = corners[k].coordinates;
  }
  return triangle;
}

MeshTriangles readMeshFile(std::string_view name, const std::string& bytes) {
  MeshTriangles read = endsIn(name, ".obj") ? readObjMesh(bytes) : readGltfMesh(bytes);
  if (read && read->empty()) {
    return tl::unexpected<std::string>("it has no triangles");
  }
  return read;
}

}  // namespace espalier::files
