#include "engine/turtle/export/mesh/ply.h"

#include <limits>
#include <map>
#include <string>

#include "engine/turtle/export/binary_output.h"
#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/placed_meshes.h"

namespace espalier::turtle {

namespace {

constexpr std::uint16_t kNoSymbol = 65'535;

// the symbol of the module that a piece of geometry comes from, by its number in the program
std::uint16_t symbolOf(const ExportInput& input, const Provenance& from) {
  const bool isKnown =
      input.program != nullptr && from.plant < input.strings.size() && from.module < input.strings[from.plant]->size();
  return isKnown ? input.program->symbolOf[input.strings[from.plant]->types()[from.module]] : kNoSymbol;
}

std::string headerOf(const ExportInput& input, std::uint64_t vertices, std::uint64_t faces) {
  std::string text = "ply\nformat binary_little_endian 1.0\ncomment Espalier: y is up\ncomment organs:";
  for (std::uint8_t kind = 0; kind <= static_cast<std::uint8_t>(OrganKind::Ball); ++kind) {
    text += " " + std::to_string(kind) + " " + std::string(organName(static_cast<OrganKind>(kind)));
  }
  for (std::size_t i = 0; input.program != nullptr && i < input.program->symbols.size(); ++i) {
    text += "\ncomment symbol " + std::to_string(i) + " " + input.program->symbols[i].name;
  }
  text += "\nelement vertex " + std::to_string(vertices) + "\n";
  for (const char* property :
       {"float x", "float y", "float z", "float nx", "float ny", "float nz", "float s", "float t", "uchar red",
        "uchar green", "uchar blue", "uchar organ", "ushort order", "ushort symbol", "uint plant", "uint module"}) {
    text += std::string("property ") + property + "\n";
  }
  return text + "element face " + std::to_string(faces) +
         "\nproperty list uchar uint vertex_indices\nproperty uint module\nend_header\n";
}

void writeVertices(const PlacedMeshes::Item& item, const Colour& colour, bool hasSymbols, const Mesh& mesh,
                   BinaryOutput& out) {
  const ExportInput& input = item.scene.input();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Provenance from = item.scene.provenanceOf(item.part, mesh, i);
    out.vector(mesh.positions[i]);
    out.vector(unitNormal(mesh.normals[i]));
    out.single(mesh.coordinates[i][0]);
    out.single(mesh.coordinates[i][1]);
    out.byte(colour.red);
    out.byte(colour.green);
    out.byte(colour.blue);
    out.byte(static_cast<unsigned char>(item.part.kind));
    out.uint16(static_cast<std::uint16_t>(std::min<std::uint32_t>(from.branchOrder, 65'535)));
    out.uint16(hasSymbols ? symbolOf(input, from) : kNoSymbol);
    out.uint32(item.copy.firstPlant + from.plant);
    out.uint32(static_cast<std::uint32_t>(from.module));
  }
}

void writeFaces(const PlacedMeshes::Item& item, const Mesh& mesh, std::uint32_t first, BinaryOutput& out) {
  for (const auto& face : mesh.faces) {
    const bool isTriangle = face[3] == Mesh::kNoVertex;
    out.byte(isTriangle ? 3 : 4);
    for (std::size_t k = 0; k < (isTriangle ? 3U : 4U); ++k) {
      out.uint32(first + face[k]);
    }
    out.uint32(static_cast<std::uint32_t>(item.scene.provenanceOf(item.part, mesh, face[2]).module));
  }
}

}  // namespace

std::optional<std::string> exportPly(const PlacedScenes& placed, const ExportTarget& target) {
  PlacedMeshes meshes(placed);
  std::uint64_t done = 0;
  const auto report = [&] { reportProgress(target.progress, ++done, 3 * meshes.partCount()); };
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  using Item = PlacedMeshes::Item;
  if (auto problem = meshes.forEach([&](const Item&, const Mesh& mesh) -> std::optional<std::string> {
        vertices += mesh.positions.size();
        faces += mesh.faces.size();
        report();
        return std::nullopt;
      })) {
    return problem;
  }
  if (vertices > std::numeric_limits<std::uint32_t>::max()) {
    return "it would have " + std::to_string(vertices) +
           " vertices and the format numbers at most 4294967295. Write fewer contour sides";
  }
  BinaryOutput out(target.sink);
  out.bytes(headerOf(placed.scenes[0], vertices, faces));
  const auto use = [&](const Item&, const Mesh&, std::string_view bytes) -> std::optional<std::string> {
    out.bytes(bytes);
    report();
    return std::nullopt;
  };
  PlacedMeshes::Spelling spelling{.use = use};
  spelling.spell = [&](const Item& item, const Mesh& mesh, std::uint64_t, std::string& bytes) {
    const bool hasSymbols = item.scene.input().program == placed.scenes[0].program;
    BinaryOutput spelled(bytes);
    writeVertices(item, meshes.materials()[item.part.material].colour, hasSymbols, mesh, spelled);
    spelled.flush();
  };
  if (auto problem = meshes.forEachSpelled(spelling)) {
    return problem;
  }
  std::uint32_t next = 0;
  spelling.number = [&](const Item&, const Mesh& mesh) -> std::uint64_t {
    const std::uint32_t first = next;
    next += static_cast<std::uint32_t>(mesh.positions.size());
    return first;
  };
  spelling.spell = [](const Item& item, const Mesh& mesh, std::uint64_t first, std::string& bytes) {
    BinaryOutput spelled(bytes);
    writeFaces(item, mesh, static_cast<std::uint32_t>(first), spelled);
    spelled.flush();
  };
  auto problem = meshes.forEachSpelled(spelling);
  out.flush();
  return problem;
}

}  // namespace espalier::turtle
