#include "engine/turtle/export/usda.h"

#include <algorithm>

#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "engine/turtle/export/mesh_check.h"
#include "engine/turtle/export/scene_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::size_t kPieceVertices = 100'000;  // about: pieces end with a part
constexpr int kStepsPerSecond = 8;

double linear(double component) {
  return component <= 0.04045 ? component / 12.92 : std::pow((component + 0.055) / 1.055, 2.4);
}

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

/// Writes the meshes of one scene below the prim of the given path.
class SceneWriter {
 public:
  SceneWriter(const ExportInput& input, std::string path, const ExportProgress& progress, TextOutput& out)
      : meshes_(input), path_(std::move(path)), progress_(progress), out_(out) {}

  [[nodiscard]] std::optional<std::string> write();

 private:
  void writeMaterials();
  void writePiece(std::uint32_t plant, std::int32_t material, std::size_t number);
  template <typename Element, typename Write>
  void writeArray(std::string_view declaration, const std::vector<Element>& elements, Write write);
  [[nodiscard]] static std::string materialName(std::int32_t material) { return "colour_" + std::to_string(material); }

  SceneMeshes meshes_;
  std::string path_;
  const ExportProgress& progress_;
  TextOutput& out_;
  Mesh piece_;
};

template <typename Element, typename Write>
void SceneWriter::writeArray(std::string_view declaration, const std::vector<Element>& elements, Write write) {
  out_ << "        " << declaration << " = [";
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (i > 0) {
      out_ << ',';
    }
    write(elements[i]);
  }
  out_ << ']';
}

void SceneWriter::writeMaterials() {
  std::map<std::int32_t, bool> used;
  for (const MeshPart& part : meshes_.parts()) {
    used.emplace(part.material, true);
  }
  out_ << "    def Scope \"materials\"\n    {\n";
  for (const auto& [material, isUsed] : used) {
    const Colour colour = meshes_.palette().ofMaterial(material);
    const std::optional<language::Material> own = meshes_.palette().folderMaterial(material);
    const std::string name = materialName(material);
    out_ << "        def Material \"" << name << "\"\n        {\n            token outputs:surface.connect = <" << path_
         << "/materials/" << name << "/shader.outputs:surface>\n            def Shader \"shader\"\n            {\n"
         << "                uniform token info:id = \"UsdPreviewSurface\"\n"
         << "                color3f inputs:diffuseColor = ";
    writeTuple({linear(colour.red / 255.0), linear(colour.green / 255.0), linear(colour.blue / 255.0)}, out_);
    out_ << "\n                float inputs:opacity = ";
    out_.single(own ? own->opacity : 1.0) << "\n                float inputs:roughness = 0.8\n"
                                          << "                token outputs:surface\n            }\n        }\n";
  }
  out_ << "    }\n";
}

void SceneWriter::writePiece(std::uint32_t plant, std::int32_t material, std::size_t number) {
  if (piece_.faces.empty()) {
    return;
  }
  out_ << "    def Mesh \"plant_";
  out_.integer(plant) << '_' << materialName(material) << '_';
  out_.integer(static_cast<long long>(number))
      << "\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n    {\n"
      << "        uniform token subdivisionScheme = \"none\"\n"
      << "        uniform bool doubleSided = 1\n"
      << "        rel material:binding = <" << path_ << "/materials/" << materialName(material) << ">\n";
  Bounds bounds;
  bounds.add(piece_);
  out_ << "        float3[] extent = [";
  writeTuple(bounds.low, out_);
  writeTuple(bounds.high, out_ << ',');
  out_ << "]\n";
  const auto writeVector = [this](const Vec3& v) { writeTuple(v, out_); };
  writeArray("point3f[] points", piece_.positions, writeVector);
  out_ << '\n';
  writeArray("normal3f[] normals", piece_.normals, [&](const Vec3& n) { writeVector(unitNormal(n)); });
  out_ << " (\n            interpolation = \"vertex\"\n        )\n";
  writeArray("texCoord2f[] primvars:st", piece_.coordinates, [this](const std::array<double, 2>& uv) {
    (out_ << '(').single(uv[0]) << ',';
    out_.single(uv[1]) << ')';
  });
  out_ << " (\n            interpolation = \"vertex\"\n        )\n";
  writeArray("int[] faceVertexCounts", piece_.faces,
             [this](const auto& face) { out_ << (face[3] == Mesh::kNoVertex ? '3' : '4'); });
  out_ << '\n';
  writeArray("int[] faceVertexIndices", piece_.faces, [this](const auto& face) {
    const std::size_t corners = face[3] == Mesh::kNoVertex ? 3 : 4;
    for (std::size_t k = 0; k < corners; ++k) {
      (k == 0 ? out_ : out_ << ',').integer(face[k]);
    }
  });
  out_ << "\n    }\n";
  piece_.clear();
}

std::optional<std::string> SceneWriter::write() {
  writeMaterials();
  // pieces of one plant and material
  const std::span<const MeshPart> parts = meshes_.parts();
  std::vector<std::uint32_t> order(parts.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&parts](std::uint32_t i) { return std::pair(parts[i].plant, parts[i].material); };
  std::ranges::stable_sort(order, {}, key);
  Mesh mesh;
  std::size_t number = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const MeshPart& part = parts[order[i]];
    meshes_.make(part, mesh);
    if (auto problem = problemOf(mesh, meshes_.provenanceOf(part))) {
      return problem;
    }
    append(piece_, mesh);
    const bool isLast = i + 1 == order.size() || key(order[i + 1]) != key(order[i]);
    if (isLast || piece_.positions.size() >= kPieceVertices) {
      writePiece(part.plant, part.material, number);
      number = isLast ? 0 : number + 1;
    }
    reportProgress(progress_, i + 1, order.size());
  }
  return std::nullopt;
}

class UsdaGrowth final : public GrowthExport {
 public:
  UsdaGrowth(const ExportTarget& target, const GrowthRange& range)
      : progress_(target.progress), range_(range), out_(target.sink) {
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
    if (auto problem = SceneWriter(input, "/espalier/" + name, progress_, out_).write()) {
      return problem;
    }
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

  ExportProgress progress_;
  GrowthRange range_;
  TextOutput out_;
};

}  // namespace

std::optional<std::string> exportUsda(const ExportInput& input, const ExportTarget& target) {
  TextOutput out(target.sink);
  writeHeader(std::nullopt, out);
  if (auto problem = SceneWriter(input, "/espalier", target.progress, out).write()) {
    return problem;
  }
  out << "}\n";
  return std::nullopt;
}

std::unique_ptr<GrowthExport> beginUsdaGrowth(const ExportTarget& target, const GrowthRange& range) {
  return std::make_unique<UsdaGrowth>(target, range);
}

}  // namespace espalier::turtle
