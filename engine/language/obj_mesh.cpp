#include <tiny_obj_loader.h>

#include <cmath>
#include <span>

#include "engine/core/polygon.h"
#include "engine/language/mesh_file.h"

namespace espalier::language {
namespace {

constexpr std::size_t kMostCorners = 10'000;  // of one face: cutting it takes their square

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

// the corners of one face; a sentence when they are not in the file
std::optional<std::string> readCorners(const tinyobj::attrib_t& numbers, std::span<const tinyobj::index_t> indices,
                                       std::vector<MeshCorner>& corners) {
  corners.clear();
  for (const tinyobj::index_t& index : indices) {
    const std::optional<core::Vec3> position = vectorAt(numbers.vertices, index.vertex_index);
    if (!position) {
      return "a face has the vertex " + std::to_string(index.vertex_index + 1) + " of " +
             std::to_string(numbers.vertices.size() / 3);
    }
    if (!isFinite(*position)) {
      return "vertex " + std::to_string(index.vertex_index + 1) + " is not finite";
    }
    MeshCorner& corner = corners.emplace_back();
    corner.position = *position;
    corner.normal = vectorAt(numbers.normals, index.normal_index);
    const int at = index.texcoord_index;
    if (at >= 0 && 2 * static_cast<std::size_t>(at) + 1 < numbers.texcoords.size()) {
      const std::size_t first = 2 * static_cast<std::size_t>(at);
      corner.coordinates = {numbers.texcoords[first], numbers.texcoords[first + 1]};
    }
  }
  return std::nullopt;
}

// a face of any number of corners as triangles
void appendFace(const std::vector<MeshCorner>& corners, std::vector<SurfaceTriangle>& triangles) {
  std::vector<core::Vec3> positions;
  for (const MeshCorner& corner : corners) {
    positions.push_back(corner.position);
  }
  for (const auto& [a, b, c] : core::triangulate(positions, core::newellNormal(positions))) {
    triangles.push_back(triangleOf({corners[a], corners[b], corners[c]}));
  }
}

}  // namespace

std::variant<std::vector<SurfaceTriangle>, std::string> readObjMesh(const std::string& text) {
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;  // it cuts concave faces wrongly
  config.vertex_color = false;
  // the material file is not read
  if (!reader.ParseFromString(text, "", config)) {
    const std::string& error = reader.Error();
    return "it is no Wavefront OBJ: " + (error.empty() ? std::string("nothing in it can be read") : error);
  }
  std::vector<SurfaceTriangle> triangles;
  std::vector<MeshCorner> corners;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    std::size_t first = 0;
    for (const std::size_t cornerCount : shape.mesh.num_face_vertices) {
      const std::span<const tinyobj::index_t> indices(shape.mesh.indices.data() + first, cornerCount);
      first += cornerCount;
      if (triangles.size() + cornerCount > kMostMeshTriangles) {
        return "it has more than " + std::to_string(kMostMeshTriangles) + " triangles";
      }
      if (cornerCount > kMostCorners) {
        return "a face has more than " + std::to_string(kMostCorners) + " corners";
      }
      if (auto problem = readCorners(reader.GetAttrib(), indices, corners)) {
        return *problem;
      }
      appendFace(corners, triangles);
    }
  }
  return triangles;
}

}  // namespace espalier::language
