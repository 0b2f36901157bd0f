#include "engine/turtle/export/mesh/stl.h"

#include <array>
#include <limits>
#include <string>

#include "engine/turtle/export/binary_output.h"
#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/placed_meshes.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::size_t kHeaderBytes = 80;

// calls `use` with the corners and the side's normal of each triangle
template <typename Use>
void forEachTriangle(const Mesh& mesh, Use use) {
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const std::array<Vec3, 3> corners{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
    const Vec3 normal = core::cross(corners[1] - corners[0], corners[2] - corners[0]);
    use(corners, core::normalised(normal));
  };
  for (const auto& face : mesh.faces) {
    triangle(face[0], face[1], face[2]);
    if (face[3] != Mesh::kNoVertex) {
      triangle(face[0], face[2], face[3]);
    }
  }
}

}  // namespace

std::optional<std::string> exportStl(const PlacedScenes& placed, const ExportTarget& target) {
  PlacedMeshes meshes(placed);
  std::uint64_t done = 0;
  const auto report = [&] { reportProgress(target.progress, ++done, 2 * meshes.partCount()); };
  std::uint64_t triangles = 0;
  using Item = PlacedMeshes::Item;
  if (auto problem = meshes.forEach([&](const Item&, const Mesh& mesh) -> std::optional<std::string> {
        triangles += mesh.triangleCount();
        report();
        return std::nullopt;
      })) {
    return problem;
  }
  if (triangles > std::numeric_limits<std::uint32_t>::max()) {
    return "it would have " + std::to_string(triangles) +
           " triangles and the format counts at most 4294967295. Write fewer contour sides";
  }
  BinaryOutput out(target.sink);
  std::string header = "Espalier: y is up";
  header.resize(kHeaderBytes, ' ');
  out.bytes(header);
  out.uint32(static_cast<std::uint32_t>(triangles));
  PlacedMeshes::Spelling spelling;
  spelling.spell = [](const Item&, const Mesh& mesh, std::uint64_t, std::string& bytes) {
    BinaryOutput spelled(bytes);
    forEachTriangle(mesh, [&spelled](const std::array<Vec3, 3>& corners, const Vec3& normal) {
      const auto& [a, b, c] = corners;
      spelled.singles(std::array{normal.x, normal.y, normal.z, a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z});
      spelled.uint16(0);
    });
    spelled.flush();
  };
  spelling.use = [&](const Item&, const Mesh&, std::string_view bytes) -> std::optional<std::string> {
    out.bytes(bytes);
    report();
    return std::nullopt;
  };
  auto problem = meshes.forEachSpelled(spelling);
  out.flush();
  return problem;
}

}  // namespace espalier::turtle
