#include <tiny_obj_loader.h>

#include <cmath>

#include "engine/language/mesh_file.h"

namespace espalier::language {
namespace {

bool isFinite(const core::Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// the vector number `index` of an array of threes; nothing when there is none
std::optional<core::Vec3> vectorAt(const std::vector<tinyobj::real_t>& numbers, int index) {
  if (index < 0 || 3 * static_cast<std::size_t>(index) + 2 >= numbers.size()) {
    return std::nullopt;
  }
  const std::size_t at = 3 * static_cast<std::size_t>(index);
  return core::Vec3{numbers[at], numbers[at + 1], numbers[at + 2]};
}

}  // namespace

std::variant<std::vector<SurfaceTriangle>, std::string> readObjMesh(const std::string& text) {
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = true;
  config.vertex_color = false;
  // the material file is not read
  if (!reader.ParseFromString(text, "", config)) {
    const std::string& error = reader.Error();
    return "it is no Wavefront OBJ: " + (error.empty() ? std::string("nothing in it can be read") : error);
  }
  const tinyobj::attrib_t& numbers = reader.GetAttrib();
  std::vector<SurfaceTriangle> triangles;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    const std::vector<tinyobj::index_t>& indices = shape.mesh.indices;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
      if (triangles.size() == kMostMeshTriangles) {
        return "it has more than " + std::to_string(kMostMeshTriangles) + " triangles";
      }
      std::array<MeshCorner, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const tinyobj::index_t& index = indices[i + k];
        const std::optional<core::Vec3> position = vectorAt(numbers.vertices, index.vertex_index);
        if (!position) {
          return "a face has the vertex " + std::to_string(index.vertex_index + 1) + " of " +
                 std::to_string(numbers.vertices.size() / 3);
        }
        if (!isFinite(*position)) {
          return "vertex " + std::to_string(index.vertex_index + 1) + " is not finite";
        }
        corners[k].position = *position;
        corners[k].normal = vectorAt(numbers.normals, index.normal_index);
        if (const int at = index.texcoord_index;
            at >= 0 && 2 * static_cast<std::size_t>(at) + 1 < numbers.texcoords.size()) {
          const std::size_t first = 2 * static_cast<std::size_t>(at);
          corners[k].coordinates = {numbers.texcoords[first], numbers.texcoords[first + 1]};
        }
      }
      triangles.push_back(triangleOf(corners));
    }
  }
  return triangles;
}

}  // namespace espalier::language
