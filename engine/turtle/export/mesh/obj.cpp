#include "engine/turtle/export/mesh/obj.h"

#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/placed_meshes.h"
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

// `vertexCount`: of the meshes before it
void writeMesh(const Mesh& mesh, std::uint64_t vertexCount, TextOutput& out) {
  for (const Vec3& p : mesh.positions) {
    (out << "v ").vector(p, ' ') << '\n';
  }
  for (const auto& uv : mesh.coordinates) {
    (out << "vt ").single(uv[0]) << ' ';
    out.single(uv[1]) << '\n';
  }
  for (const Vec3& n : mesh.normals) {
    (out << "vn ").vector(unitNormal(n), ' ') << '\n';
  }
  for (const auto& face : mesh.faces) {
    out << 'f';
    for (const std::uint32_t vertex : face) {
      if (vertex == Mesh::kNoVertex) {
        continue;
      }
      out << ' ';
      for (int k = 0; k < 3; ++k) {
        (k == 0 ? out : out << '/').integer(static_cast<long long>(vertexCount + vertex + 1));
      }
    }
    out << '\n';
  }
}

class ObjWriter {
 public:
  ObjWriter(const PlacedScenes& placed, const ExportTarget& target)
      : meshes_(placed), target_(target), out_(target.sink) {}

  [[nodiscard]] std::optional<std::string> write(const std::string& materialFile);
  /// The materials in use, and beside them the pictures that they wear.
  void writeMaterials(core::ByteSink& sink) const;

 private:
  static constexpr std::uint32_t kNoMaterial = 0xFFFFFFFF;

  void beginOrgans(std::uint32_t plant, OrganKind kind);
  void useMaterial(std::uint32_t material);

  PlacedMeshes meshes_;
  const ExportTarget& target_;
  TextOutput out_;
  std::set<std::uint32_t> used_;
  std::uint32_t current_ = kNoMaterial;
  std::uint64_t vertexCount_ = 0;  // written so far: positions, normals and texture coordinates run together
};

// one group for each kind of organ of each plant
void ObjWriter::beginOrgans(std::uint32_t plant, OrganKind kind) {
  const std::string name = "plant_" + std::to_string(plant);
  out_ << "o " << name << '_' << organName(kind) << "\ng " << name << ' ' << organName(kind) << '\n';
}

void ObjWriter::useMaterial(std::uint32_t material) {
  if (material != current_) {
    out_ << "usemtl " << meshes_.materials()[material].name << '\n';
    current_ = material;
    used_.insert(material);
  }
}

std::optional<std::string> ObjWriter::write(const std::string& materialFile) {
  out_ << "# Espalier: 1 unit is 1 length unit of the model, y is up\n";
  if (!materialFile.empty()) {
    out_ << "mtllib " << materialFile << '\n';
  }
  std::optional<std::pair<std::uint32_t, OrganKind>> last;
  std::uint64_t done = 0;
  using Item = PlacedMeshes::Item;
  PlacedMeshes::Spelling spelling;
  spelling.number = [&](const Item&, const Mesh& mesh) {
    const std::uint64_t before = vertexCount_;
    vertexCount_ += mesh.faces.empty() ? 0 : mesh.positions.size();
    return before;
  };
  spelling.spell = [](const Item&, const Mesh& mesh, std::uint64_t vertexCount, std::string& text) {
    if (!mesh.faces.empty()) {
      TextOutput out(text);
      writeMesh(mesh, vertexCount, out);
      out.flush();
    }
  };
  spelling.use = [&](const Item& item, const Mesh& mesh, std::string_view text) -> std::optional<std::string> {
    if (!mesh.faces.empty()) {
      if (last != std::pair(item.plant(), item.part.kind)) {
        last = std::pair(item.plant(), item.part.kind);
        beginOrgans(item.plant(), item.part.kind);
      }
      useMaterial(item.part.material);
      out_ << text;
    }
    reportProgress(target_.progress, ++done, meshes_.partCount());
    return std::nullopt;
  };
  auto problem = meshes_.forEachSpelled(spelling);
  out_.flush();
  return problem;
}

void ObjWriter::writeMaterials(core::ByteSink& sink) const {
  TextOutput out(sink);
  std::set<std::uint32_t> textures;
  const auto pictureName = [this](const MeshTexture& texture) {
    return withSuffix(target_.fileName, "_" + texture.name + texture.suffix());
  };
  for (const std::uint32_t index : used_) {
    const MeshMaterial& material = meshes_.materials()[index];
    const bool isTextured = material.texture != MeshMaterial::kNoTexture;
    const MeshTexture* const texture = isTextured ? &meshes_.textures()[material.texture] : nullptr;
    const bool isCovered = isTextured && texture->texture->use == files::Texture::Use::Decal;
    out << "newmtl " << material.name << '\n';
    writeComponents("Kd", isCovered ? std::array{1.0, 1.0, 1.0} : material.diffuse(), out);
    if (material.folder) {
      writeComponents("Ka", material.folder->ambient, out);
      writeComponents("Ks", material.folder->specular, out);
      writeComponents("Ke", material.folder->emission, out);
      out << "Ns ";
      out.number(material.folder->shininess, 4) << "\nd ";
      out.number(material.folder->opacity, 4) << "\nillum 2\n";
    } else {
      out << "Ka 0 0 0\nKs 0.04 0.04 0.04\nNs 10\nillum 2\n";
    }
    if (isTextured) {
      out << "map_Kd " << pictureName(*texture) << '\n';
      if (texture->hasHoles()) {
        out << "map_d " << pictureName(*texture) << '\n';
      }
      textures.insert(material.texture);
    }
  }
  out.flush();
  for (const std::uint32_t index : textures) {
    const MeshTexture& texture = meshes_.textures()[index];
    target_.openCompanion(pictureName(texture)).write(texture.fileBytes());
  }
}

}  // namespace

std::optional<std::string> exportObj(const PlacedScenes& placed, const ExportTarget& target) {
  ObjWriter writer(placed, target);
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
