#include "engine/turtle/export/obj.h"

#include <array>
#include <optional>
#include <set>
#include <string>

#include "engine/turtle/export/mesh_check.h"
#include "engine/turtle/export/scene_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

void writeComponents(std::string_view keyword, const std::array<double, 3>& components, TextOutput& out) {
  out << keyword;
  for (const double component : components) {
    out << ' ';
    out.number(component, 4);
  }
  out << '\n';
}

class ObjWriter {
 public:
  ObjWriter(const ExportInput& input, const ExportTarget& target)
      : meshes_(input), progress_(target.progress), out_(target.sink) {}

  [[nodiscard]] std::optional<std::string> write(const std::string& materialFile);
  void writeMaterials(core::ByteSink& sink) const;

 private:
  void beginOrgans(const MeshPart& part);
  void writeMesh();
  void useMaterial(std::int32_t material);

  SceneMeshes meshes_;
  const ExportProgress& progress_;
  TextOutput out_;
  Mesh mesh_;
  std::set<std::int32_t> used_;
  std::int32_t current_ = -1;      // material in use; -1: none
  std::uint64_t vertexCount_ = 0;  // written so far: positions, normals and texture coordinates run together
};

// one group for each kind of organ of each plant
void ObjWriter::beginOrgans(const MeshPart& part) {
  const std::string plant = "plant_" + std::to_string(part.plant);
  const std::string_view kind = organName(part.kind);
  out_ << "o " << plant << '_' << kind << "\ng " << plant << ' ' << kind << '\n';
}

void ObjWriter::useMaterial(std::int32_t material) {
  if (material != current_) {
    out_ << "usemtl colour_";
    out_.integer(material) << '\n';
    current_ = material;
    used_.insert(material);
  }
}

void ObjWriter::writeMesh() {
  for (const Vec3& p : mesh_.positions) {
    (out_ << "v ").vector(p, ' ') << '\n';
  }
  for (const auto& uv : mesh_.coordinates) {
    (out_ << "vt ").single(uv[0]) << ' ';
    out_.single(uv[1]) << '\n';
  }
  for (const Vec3& n : mesh_.normals) {
    (out_ << "vn ").vector(unitNormal(n), ' ') << '\n';
  }
  for (const auto& face : mesh_.faces) {
    out_ << 'f';
    for (const std::uint32_t vertex : face) {
      if (vertex == Mesh::kNoVertex) {
        continue;
      }
      const std::string index = std::to_string(vertexCount_ + vertex + 1);
      out_ << ' ' << index << '/' << index << '/' << index;
    }
    out_ << '\n';
  }
  vertexCount_ += mesh_.positions.size();
}

std::optional<std::string> ObjWriter::write(const std::string& materialFile) {
  out_ << "# Espalier: 1 unit is 1 length unit of the model, y is up\n";
  if (!materialFile.empty()) {
    out_ << "mtllib " << materialFile << '\n';
  }
  const std::span<const MeshPart> parts = meshes_.parts();
  const MeshPart* last = nullptr;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const MeshPart& part = parts[i];
    meshes_.make(part, mesh_);
    if (auto problem = problemOf(mesh_, meshes_.provenanceOf(part))) {
      return problem;
    }
    if (!mesh_.faces.empty()) {
      if (last == nullptr || last->plant != part.plant || last->kind != part.kind) {
        beginOrgans(part);
        last = &part;
      }
      useMaterial(part.material);
      writeMesh();
    }
    reportProgress(progress_, i + 1, parts.size());
  }
  out_.flush();
  return std::nullopt;
}

void ObjWriter::writeMaterials(core::ByteSink& sink) const {
  TextOutput out(sink);
  for (const std::int32_t material : used_) {
    out << "newmtl colour_";
    out.integer(material) << '\n';
    if (const std::optional<language::Material> own = meshes_.palette().folderMaterial(material)) {
      writeComponents("Kd", own->diffuse, out);
      writeComponents("Ka", own->ambient, out);
      writeComponents("Ks", own->specular, out);
      writeComponents("Ke", own->emission, out);
      out << "Ns ";
      out.number(own->shininess, 4) << "\nd ";
      out.number(own->opacity, 4) << "\nillum 2\n";
      continue;
    }
    const Colour colour = meshes_.palette().ofMaterial(material);
    writeComponents("Kd", {colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0}, out);
    out << "Ka 0 0 0\nKs 0.04 0.04 0.04\nNs 10\nillum 2\n";
  }
}

}  // namespace

std::optional<std::string> exportObj(const ExportInput& input, const ExportTarget& target) {
  ObjWriter writer(input, target);
  const std::string materialFile = target.openCompanion ? withSuffix(target.fileName, ".mtl") : "";
  if (auto problem = writer.write(materialFile)) {
    return problem;
  }
  if (!materialFile.empty()) {
    writer.writeMaterials(target.openCompanion(materialFile));
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
