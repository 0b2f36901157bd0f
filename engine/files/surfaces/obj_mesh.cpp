#include <tiny_obj_loader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>

#include "engine/core/polygon.h"
#include "engine/files/surfaces/mesh_file.h"

namespace espalier::files {
namespace {

constexpr std::size_t kMostCorners = 10'000;  // of one face: the time to cut it grows with their square

// vector `index` of an array of threes; nothing when there is none
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

namespace {

/// The first vertex line without three finite coordinates, as a sentence: the library would read 0 there.
std::optional<std::string> wrongVertex(std::string_view text) {
  std::size_t line = 0;
  while (!text.empty()) {
    ++line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view rest = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    constexpr std::string_view kBlanks = " \t\r";
    rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
    if (!rest.starts_with("v ") && !rest.starts_with("v\t")) {
      continue;
    }
    rest.remove_prefix(1);
    for (int axis = 0; axis < 3; ++axis) {
      rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
      const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
      const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
      double number = 0.0;
      const auto [last, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
      const bool isTiny = problem == std::errc::result_out_of_range && digits.find("e-") != std::string_view::npos;
      if ((problem != std::errc() && !isTiny) || last != digits.data() + digits.size() || !std::isfinite(number)) {
        return "line " + std::to_string(line) + ": a vertex has " +
               (word.empty() ? "fewer than three coordinates"
                             : "the coordinate '" + std::string(word) + "', which is not a finite number");
      }
      rest.remove_prefix(word.size());
    }
  }
  return std::nullopt;
}

}  // namespace

MeshTriangles readObjMesh(const std::string& text) {
  if (auto problem = wrongVertex(text)) {
    return tl::unexpected(*problem);
  }
  tinyobj::ObjReader reader;
  tinyobj::ObjReaderConfig config;
  config.triangulate = false;  // the library cuts concave faces wrongly
  config.vertex_color = false;
  // the material file is not read
  if (!reader.ParseFromString(text, "", config)) {
    const std::string& error = reader.Error();
    return tl::unexpected("it is not a Wavefront OBJ file: " +
                          (error.empty() ? std::string("it has no readable line") : error));
  }
  std::vector<SurfaceTriangle> triangles;
  std::vector<MeshCorner> corners;
  for (const tinyobj::shape_t& shape : reader.GetShapes()) {
    std::size_t first = 0;
    for (const std::size_t cornerCount : shape.mesh.num_face_vertices) {
      const std::span<const tinyobj::index_t> indices(shape.mesh.indices.data() + first, cornerCount);
      first += cornerCount;
      if (triangles.size() + cornerCount > kMostMeshTriangles) {
        return tl::unexpected("it has more than " + std::to_string(kMostMeshTriangles) + " triangles");
      }
      if (cornerCount > kMostCorners) {
        return tl::unexpected("a face has more than " + std::to_string(kMostCorners) + " corners");
      }
      if (auto problem = readCorners(reader.GetAttrib(), indices, corners)) {
        return tl::unexpected(*problem);
      }
      appendFace(corners, triangles);
    }
  }
  return triangles;
}

}  // namespace espalier::files
