#include "engine/turtle/export/mesh/usda.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/mesh_work.h"
#include "engine/turtle/export/mesh/placed_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::size_t kPieceVertices = 100'000;  // about: pieces end with a part
constexpr int kStepsPerSecond = 8;

void writeTuple(const Vec3& v, TextOutput& out) {
  (out << '(').vector(v, ',') << ')';
}

void writeHeader(const std::optional<GrowthRange>& range, TextOutput& out) {
  out << "#usda 1.0\n(\n    defaultPrim = \"espalier\"\n    upAxis = \"Y\"\n    metersPerUnit = 1\n";
  if (range) {
    out << "    startTimeCode = ";
    out.integer(static_cast<long long>(range->firstStep)) << "\n    endTimeCode = ";
    out.integer(static_cast<long long>(range->lastStep)) << "\n    timeCodesPerSecond = ";
    out.integer(kStepsPerSecond) << '\n';
  }
  out << ")\n\ndef Xform \"espalier\"\n{\n";
}

/// The arrays of a mesh. Each is spelled as its elements with commas between; a piece puts brackets around them.
enum MeshArray : std::size_t { kPoints, kNormals, kCoordinates, kFaceCounts, kFaceIndices };
constexpr std::size_t kArrayCount = 5;

template <typename Element, typename Write>
void writeElements(const std::vector<Element>& elements, TextOutput& out, Write write) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i > 0) {
      out << ',';
    }
    write(elements[i]);
  }
}

void writeArray(MeshArray array, const Mesh& mesh, std::uint64_t firstVertex, TextOutput& out) {
  switch (array) {
    case kPoints:
      return writeElements(mesh.positions, out, [&out](const Vec3& p) { writeTuple(p, out); });
    case kNormals:
      return writeElements(mesh.normals, out, [&out](const Vec3& n) { writeTuple(unitNormal(n), out); });
    case kCoordinates:
      return writeElements(mesh.coordinates, out, [&out](const std::array<double, 2>& uv) {
        (out << '(').single(uv[0]) << ',';
        out.single(uv[1]) << ')';
      });
    case kFaceCounts:
      return writeElements(mesh.faces, out,
                           [&out](const auto& face) { out << (face[3] == Mesh::kNoVertex ? '3' : '4'); });
    case kFaceIndices:
      return writeElements(mesh.faces, out, [&out, firstVertex](const auto& face) {
        const std::size_t corners = face[3] == Mesh::kNoVertex ? 3 : 4;
        for (std::size_t k = 0; k < corners; ++k) {
          (k == 0 ? out : out << ',').integer(static_cast<long long>(firstVertex + face[k]));
        }
      });
  }
}

/// Appends the lengths of all arrays and then their text.
void spellArrays(const Mesh& mesh, std::uint64_t firstVertex, std::string& bytes) {
  const std::size_t start = bytes.size();
  std::array<std::size_t, kArrayCount> lengths{};
  bytes.append(sizeof(lengths), '\0');
  for (std::size_t array = 0; array < kArrayCount; ++array) {
    const std::size_t before = bytes.size();
    TextOutput out(bytes);
    writeArray(static_cast<MeshArray>(array), mesh, firstVertex, out);
    out.flush();
    lengths[array] = bytes.size() - before;
  }
  std::memcpy(bytes.data() + start, lengths.data(), sizeof(lengths));
}

/// Some meshes in a row that are written as one: the arrays of all of them.
struct PieceText {
  std::array<std::string, kArrayCount> arrays;
  Bounds bounds{};
  std::size_t vertexCount = 0;

  /// `spelled` by spellArrays.
  void add(const Mesh& mesh, std::string_view spelled) {
    std::array<std::size_t, kArrayCount> lengths{};
    std::memcpy(lengths.data(), spelled.data(), sizeof(lengths));
    spelled.remove_prefix(sizeof(lengths));
    for (std::size_t array = 0; array < kArrayCount; ++array) {
      const bool isBetween = !arrays[array].empty() && lengths[array] > 0;
      arrays[array].append(isBetween ? "," : "").append(spelled.substr(0, lengths[array]));
      spelled.remove_prefix(lengths[array]);
    }
    bounds.add(mesh);
    vertexCount += mesh.positions.size();
  }
  void clear() {
    for (std::string& array : arrays) {
      array.clear();
    }
    bounds = {};
    vertexCount = 0;
  }
};

/// Writes the meshes of one scene below the prim of the given path.
class SceneWriter {
 public:
  SceneWriter(const PlacedScenes& placed, std::string path, const ExportTarget& target, TextOutput& out)
      : meshes_(placed), path_(std::move(path)), target_(target), out_(out) {}

  [[nodiscard]] std::optional<std::string> write();
  /// The pictures that the meshes wear go beside the file, those that are not among `written` yet.
  void writePictures(std::set<std::string>& written) const;

 private:
  void writeMaterials();
  void writeTexture(const MeshMaterial& material, const std::string& path);
  void writePiece(std::uint32_t plant, std::uint32_t material);
  [[nodiscard]] std::string pictureName(const MeshTexture& texture) const {
    return withSuffix(target_.fileName, "_" + texture.name + texture.suffix());
  }
  [[nodiscard]] const std::string& materialName(std::uint32_t material) const {
    return meshes_.materials()[material].name;
  }

  PlacedMeshes meshes_;
  std::string path_;
  const ExportTarget& target_;
  TextOutput& out_;
  PieceText piece_;
  std::size_t pieceNumber_ = 0;  // among those of the same plant and material in a row
};

// the picture, its place on the mesh, and how it meets the colour
void SceneWriter::writeTexture(const MeshMaterial& material, const std::string& path) {
  const MeshTexture& texture = meshes_.textures()[material.texture];
  const bool isCovered = texture.texture->use == files::Texture::Use::Decal;
  const std::array<double, 3> diffuse = material.diffuse();
  const auto scale = [&](std::size_t k) { return isCovered ? 1.0 : linearComponent(diffuse[k]); };
  out_ << "            def Shader \"picture\"\n            {\n"
       << "                uniform token info:id = \"UsdUVTexture\"\n                asset inputs:file = @./"
       << pictureName(texture) << "@\n                float2 inputs:st.connect = <" << path
       << "/place.outputs:result>\n"
       << "                token inputs:wrapS = \"repeat\"\n                token inputs:wrapT = \"repeat\"\n"
       << "                float4 inputs:scale = (";
  (out_.vector({scale(0), scale(1), scale(2)}, ',') << ",1)\n")
      << "                float3 outputs:rgb\n                float outputs:a\n            }\n"
      << "            def Shader \"place\"\n            {\n"
      << "                uniform token info:id = \"UsdPrimvarReader_float2\"\n"
      << "                string inputs:varname = \"st\"\n                float2 outputs:result\n            }\n";
}

void SceneWriter::writeMaterials() {
  out_ << "    def Scope \"materials\"\n    {\n";
  for (const MeshMaterial& material : meshes_.materials()) {
    const std::string path = path_ + "/materials/" + material.name;
    const bool isTextured = material.texture != MeshMaterial::kNoTexture && target_.openCompanion != nullptr;
    out_ << "        def Material \"" << material.name << "\"\n        {\n            token outputs:surface.connect = <"
         << path << "/shader.outputs:surface>\n            def Shader \"shader\"\n            {\n"
         << "                uniform token info:id = \"UsdPreviewSurface\"\n"
         << "                color3f inputs:diffuseColor";
    if (isTextured) {
      out_ << ".connect = <" << path << "/picture.outputs:rgb>\n";
      if (meshes_.textures()[material.texture].hasHoles()) {
        out_ << "                float inputs:opacity.connect = <" << path << "/picture.outputs:a>\n"
             << "                float inputs:opacityThreshold = 0.5\n";
      }
    } else {
      const Colour& colour = material.colour;
      writeTuple({linearComponent(colour.red / 255.0), linearComponent(colour.green / 255.0),
                  linearComponent(colour.blue / 255.0)},
                 out_ << " = ");
      out_ << "\n                float inputs:opacity = ";
      out_.single(material.opacity()) << '\n';
    }
    out_ << "                float inputs:roughness = 0.8\n"
         << "                token outputs:surface\n            }\n";
    if (isTextured) {
      writeTexture(material, path);
    }
    out_ << "        }\n";
  }
  out_ << "    }\n";
}

void SceneWriter::writePiece(std::uint32_t plant, std::uint32_t material) {
  if (piece_.arrays[kFaceCounts].empty()) {
    piece_.clear();
    return;
  }
  out_ << "    def Mesh \"plant_";
  out_.integer(plant) << '_' << materialName(material) << '_';
  out_.integer(static_cast<long long>(pieceNumber_++))
      << "\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {\n"
      << "        uniform token subdivisionScheme = \"none\"\n"
      << "        uniform bool doubleSided = 1\n"
      << "        rel material:binding = <" << path_ << "/materials/" << materialName(material) << ">\n";
  out_ << "        float3[] extent = [";
  writeTuple(piece_.bounds.low, out_);
  writeTuple(piece_.bounds.high, out_ << ',');
  out_ << "]\n";
  const auto write = [this](std::string_view declaration, MeshArray array) -> TextOutput& {
    return out_ << "        " << declaration << " = [" << piece_.arrays[array] << ']';
  };
  constexpr std::string_view kByVertex = " (\n            interpolation = \"vertex\"\n        )\n";
  write("point3f[] points", kPoints) << '\n';
  write("normal3f[] normals", kNormals) << kByVertex;
  write("texCoord2f[] primvars:st", kCoordinates) << kByVertex;
  write("int[] faceVertexCounts", kFaceCounts) << '\n';
  write("int[] faceVertexIndices", kFaceIndices) << "\n    }\n";
  piece_.clear();
}

std::optional<std::string> SceneWriter::write() {
  writeMaterials();
  std::uint64_t done = 0;
  for (const SceneCopy& copy : meshes_.copies()) {
    // pieces of one plant and material
    const SceneMeshes& scene = meshes_.scene(copy.scene);
    const std::span<const MeshPart> parts = scene.parts();
    std::vector<std::uint32_t> order(parts.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto key = [&parts](std::uint32_t i) { return std::pair(parts[i].plant, parts[i].material); };
    std::ranges::stable_sort(order, {}, key);
    MeshWork work;
    work.make = [&](std::size_t i, Mesh& mesh) {
      scene.make(parts[order[i]], mesh);
      place(mesh, copy.placement);
      return problemOf(mesh, scene, parts[order[i]]);
    };
    const auto isLastOfKey = [&](std::size_t i) { return i + 1 == order.size() || key(order[i + 1]) != key(order[i]); };
    const auto endsPiece = [&](std::size_t i, std::size_t vertexCount) {
      return isLastOfKey(i) || vertexCount >= kPieceVertices;
    };
    // the number of a mesh's first vertex in its piece
    work.number = [&, vertexCount = std::size_t{0}](std::size_t i, const Mesh& mesh) mutable {
      const std::size_t first = vertexCount;
      vertexCount += mesh.positions.size();
      vertexCount = endsPiece(i, vertexCount) ? 0 : vertexCount;
      return first;
    };
    work.spell = [](std::size_t, const Mesh& mesh, std::uint64_t firstVertex, std::string& bytes) {
      spellArrays(mesh, firstVertex, bytes);
    };
    work.use = [&](std::size_t i, const Mesh& mesh, std::string_view bytes) -> std::optional<std::string> {
      const MeshPart& part = parts[order[i]];
      piece_.add(mesh, bytes);
      if (endsPiece(i, piece_.vertexCount)) {
        writePiece(copy.firstPlant + part.plant, part.material);
        pieceNumber_ = isLastOfKey(i) ? 0 : pieceNumber_;
      }
      reportProgress(target_.progress, ++done, meshes_.partCount());
      return std::nullopt;
    };
    if (auto problem = forMeshes(meshes_.team(), order.size(), work)) {
      return problem;
    }
  }
  return std::nullopt;
}

void SceneWriter::writePictures(std::set<std::string>& written) const {
  for (const MeshTexture& texture : meshes_.textures()) {
    const std::string name = pictureName(texture);
    if (target_.openCompanion && written.insert(name).second) {
      target_.openCompanion(name).write(texture.fileBytes());
    }
  }
}

class UsdaGrowth final : public GrowthExport {
 public:
  UsdaGrowth(const ExportTarget& target, const GrowthRange& range) : target_(target), range_(range), out_(target.sink) {
    writeHeader(range, out_);
  }

  [[nodiscard]] std::optional<std::string> addFrame(const ExportInput& input, std::uint64_t step) override {
    const std::string name = "step_" + std::to_string(step);
    out_ << "def Xform \"" << name << "\"\n{\n    token visibility.timeSamples = {\n";
    // hidden before its step and from the next frame on
    if (step > range_.firstStep) {
      writeSample(range_.firstStep, "invisible");
    }
    writeSample(step, "inherited");
    if (step + range_.every <= range_.lastStep) {
      writeSample(step + range_.every, "invisible");
    }
    out_ << "    }\n";
    const ScenePlacement here;
    SceneWriter writer({{&input, 1}, {&here, 1}}, "/espalier/" + name, target_, out_);
    if (auto problem = writer.write()) {
      return problem;
    }
    writer.writePictures(pictures_);
    out_ << "}\n";
    return std::nullopt;
  }

  void finish() override {
    out_ << "}\n";
    out_.flush();
  }

 private:
  void writeSample(std::uint64_t step, std::string_view value) {
    out_ << "        ";
    out_.integer(static_cast<long long>(step)) << ": \"" << value << "\",\n";
  }

  const ExportTarget& target_;
  std::set<std::string> pictures_;  // written
  GrowthRange range_;
  TextOutput out_;
};

}  // namespace

std::optional<std::string> exportUsda(const PlacedScenes& placed, const ExportTarget& target) {
  TextOutput out(target.sink);
  writeHeader(std::nullopt, out);
  SceneWriter writer(placed, "/espalier", target, out);
  if (auto problem = writer.write()) {
    return problem;
  }
  std::set<std::string> written;
  writer.writePictures(written);
  out << "}\n";
  out.flush();
  return std::nullopt;
}

std::unique_ptr<GrowthExport> beginUsdaGrowth(const ExportTarget& target, const GrowthRange& range) {
  return std::make_unique<UsdaGrowth>(target, range);
}

}  // namespace espalier::turtle
