#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "engine/files/surfaces/surface_file.h"

namespace espalier::files {
namespace {

using core::Vec3;

constexpr std::string_view kSeparators = " \t\r,:";
constexpr std::size_t kMostNumbers = 9;

struct Vertex {
  Vec3 position;
  std::optional<Vec3> normal;
  std::array<double, 2> coordinates{};
};

/// The vertex of a line; nothing when it has fewer than three numbers.
std::optional<Vertex> readVertex(TextCursor line) {
  std::array<double, kMostNumbers> numbers{};
  std::size_t count = 0;
  while (count < numbers.size()) {
    line.skip(kSeparators);
    const std::optional<double> number = line.number();
    if (!number) {
      break;
    }
    numbers[count++] = *number;
  }
  if (count < 3) {
    return std::nullopt;
  }
  Vertex vertex{{numbers[0], numbers[1], numbers[2]}, std::nullopt, {}};
  if (count >= 6) {
    vertex.normal = Vec3{numbers[3], numbers[4], numbers[5]};
  }
  if (count >= 8) {
    vertex.coordinates = {numbers[6], numbers[7]};
  }
  return vertex;
}

/// The next line that is not blank.
TextCursor nextLine(TextCursor& cursor) {
  TextCursor line = cursor.takeLine();
  while (line.atLineEnd() && !cursor.atEnd()) {
    line = cursor.takeLine();
  }
  return line;
}

}  // namespace

std::optional<TriangleSurface> readTriangleSurfaceFile(const DataFile& file, char id, double scale) {
  TriangleSurface surface;
  surface.id = id;
  surface.file = file.name();
  TextCursor cursor = file.cursor();
  while (!cursor.atEnd()) {
    TextCursor line = cursor.takeLine();
    line.skip(kSeparators);
    if (!line.rest().starts_with("triangle")) {
      continue;
    }
    SurfaceTriangle triangle;
    std::array<std::optional<Vec3>, 3> normals;
    for (std::size_t i = 0; i < 3; ++i) {
      const TextCursor vertexLine = nextLine(cursor);
      const std::optional<Vertex> vertex = readVertex(vertexLine);
      if (!vertex) {
        file.warnExpected(vertexLine, "at least three numbers of a vertex", "a triangle",
                          "the surface is undefined; --compat cpfg draws nothing for it");
        return std::nullopt;
      }
      triangle.points[i] = vertex->position * scale;
      triangle.coordinates[i] = vertex->coordinates;
      normals[i] = vertex->normal;
    }
    const Vec3 faceNormal =
        core::normalised(core::cross(triangle.points[1] - triangle.points[0], triangle.points[2] - triangle.points[0]));
    for (std::size_t i = 0; i < 3; ++i) {
      triangle.normals[i] = normals[i].value_or(faceNormal);
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

}  // namespace espalier::files
