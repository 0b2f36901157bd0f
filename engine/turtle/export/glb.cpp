#include "engine/turtle/export/glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/turtle/export/binary_output.h"
#include "engine/turtle/export/mesh_check.h"
#include "engine/turtle/export/scene_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::uint64_t kVertexBytes = 32;  // position, normal, texture coordinates
constexpr std::uint64_t kIndexBytes = 4;
constexpr std::uint64_t kPieceVertices = 1'000'000;  // about: pieces end with a part
constexpr std::size_t kMostOrganNodes = 100'000;     // viewers take no more; beyond, organs become part of the meshes
constexpr double kDefaultRoughness = 0.8;

/// A run of parts that becomes one primitive: vertices and indices that follow each other in the file.
struct Piece {
  std::size_t firstPart = 0;  // into the order of parts
  std::size_t partCount = 0;
  std::uint64_t vertexCount = 0;
  std::uint64_t indexCount = 0;
  Bounds bounds{};
  std::uint64_t offset = 0;  // in the binary chunk

  [[nodiscard]] std::uint64_t bytes() const { return vertexCount * kVertexBytes + indexCount * kIndexBytes; }
  void add(const Mesh& mesh) {
    vertexCount += mesh.positions.size();
    indexCount += 3 * mesh.triangleCount();
    bounds.add(mesh);
  }
};

/// A mesh of the file: the pieces of one material of a plant, or a shape that organs share in one material.
struct FileMesh {
  std::string name;
  std::int32_t material = 0;
  std::size_t firstPiece = 0;
  std::size_t pieceCount = 1;
};

/// What stands below a plant's node.
struct PlantContent {
  std::uint32_t plant = 0;
  std::vector<std::size_t> meshes;  // into the file's meshes
  std::size_t firstOrgan = 0;       // into the parts drawn as nodes
  std::size_t organCount = 0;
  std::size_t firstChild = 0;  // node
};

class CountingSink final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override { count_ += bytes.size(); }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::uint64_t count_ = 0;
};

double linear(double component) {
  return component <= 0.04045 ? component / 12.92 : std::pow((component + 0.055) / 1.055, 2.4);
}

// x, y, z, w of the rotation that takes x, y, z to left, heading, up; nothing when these are no rotation
std::optional<std::array<double, 4>> rotationOf(const core::Frame& frame) {
  const Vec3 &a = frame.left, &b = frame.heading, &c = frame.up;
  const double error = std::abs(core::dot(a, b)) + std::abs(core::dot(b, c)) + std::abs(core::dot(a, c)) +
                       std::abs(core::length(a) - 1.0) + std::abs(core::length(b) - 1.0) +
                       core::length(core::cross(a, b) - c);
  if (!(error < 1e-5)) {
    return std::nullopt;
  }
  // Shepperd 1978: from the largest component
  std::array<double, 4> q{};
  if (a.x + b.y + c.z > 0.0) {
    q = {b.z - c.y, c.x - a.z, a.y - b.x, 1.0 + a.x + b.y + c.z};
  } else if (a.x > b.y && a.x > c.z) {
    q = {1.0 + a.x - b.y - c.z, a.y + b.x, c.x + a.z, b.z - c.y};
  } else if (b.y > c.z) {
    q = {a.y + b.x, 1.0 + b.y - a.x - c.z, b.z + c.y, c.x - a.z};
  } else {
    q = {c.x + a.z, b.z + c.y, 1.0 + c.z - a.x - b.y, a.y - b.x};
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& component : q) {
    component /= norm;
  }
  return q;
}

// a frame that is no rotation has no place in a node, and not all programs turn the sides of a mirrored one
bool fitsNode(const OrganPlacement& placement) {
  return placement.scale.x * placement.scale.y * placement.scale.z > 0.0 && rotationOf(placement.frame).has_value();
}

class GlbWriter {
 public:
  GlbWriter(const ExportInput& input, const ExportTarget& target) : meshes_(input), target_(target) {}

  [[nodiscard]] std::optional<std::string> write();

 private:
  // the plan: what is in the file, without its meshes
  void sortParts();
  [[nodiscard]] std::optional<std::string> measurePieces();
  void planOrgans();
  void planPlants();
  void placePieces();

  // the text
  void writeJson(core::ByteSink& sink) const;
  void writeNodes(TextOutput& out) const;
  void writeOrganNode(const MeshPart& part, TextOutput& out) const;
  void writeMeshes(TextOutput& out) const;
  void writeMaterials(TextOutput& out) const;
  void writeAccessors(TextOutput& out) const;
  void writeBufferViews(TextOutput& out) const;

  // the numbers
  void writePieces();
  void writeVertices(const Mesh& mesh, BinaryOutput& out) const;
  static void appendIndices(const Mesh& mesh, std::uint32_t first, std::vector<std::uint32_t>& indices);

  [[nodiscard]] const MeshPart& part(std::size_t i) const { return meshes_.parts()[i]; }
  void report(std::size_t done) { reportProgress(target_.progress, done, 2 * own_.size()); }

  SceneMeshes meshes_;
  const ExportTarget& target_;
  std::vector<std::uint32_t> own_;     // parts with vertices of their own, by plant and material
  std::vector<std::uint32_t> organs_;  // parts drawn as nodes, by plant
  std::vector<Piece> pieces_;          // own ones, then the shared shapes in use
  std::size_t ownPieceCount_ = 0;
  std::vector<FileMesh> files_;
  std::map<std::pair<std::uint32_t, std::int32_t>, std::size_t> organMesh_;  // by shape and material
  std::vector<std::uint32_t> shapes_;                                        // of the shared pieces, in order
  std::vector<PlantContent> plants_;
  std::map<std::int32_t, std::size_t> materialIndex_;
  std::uint64_t binaryBytes_ = 0;
};

void GlbWriter::sortParts() {
  const std::span<const MeshPart> parts = meshes_.parts();
  const auto isShared = [this](const MeshPart& p) { return meshes_.sharedMeshOf(p) != SceneMeshes::kNotShared; };
  const bool hasNodes = static_cast<std::size_t>(std::ranges::count_if(parts, isShared)) <= kMostOrganNodes;
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    (hasNodes && isShared(parts[i]) && fitsNode(meshes_.placementOf(parts[i])) ? organs_ : own_).push_back(i);
  }
  std::ranges::stable_sort(own_, {}, [this](std::uint32_t i) { return std::pair(part(i).plant, part(i).material); });
}

std::optional<std::string> GlbWriter::measurePieces() {
  Mesh mesh;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const MeshPart& next = part(own_[i]);
    meshes_.make(next, mesh);
    report(i + 1);
    if (auto problem = problemOf(mesh, meshes_.provenanceOf(next))) {
      return problem;
    }
    const bool continuesMesh =
        i > 0 && part(own_[i - 1]).plant == next.plant && part(own_[i - 1]).material == next.material;
    if (!continuesMesh || pieces_.back().vertexCount >= kPieceVertices) {
      pieces_.push_back({.firstPart = i});
    }
    ++pieces_.back().partCount;
    pieces_.back().add(mesh);
  }
  // lines without length or polygons without three corners have no mesh
  std::erase_if(pieces_, [](const Piece& piece) { return piece.indexCount == 0; });
  ownPieceCount_ = pieces_.size();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const MeshPart& first = part(own_[pieces_[i].firstPart]);
    const bool continuesMesh = i > 0 && part(own_[pieces_[i - 1].firstPart]).plant == first.plant &&
                               part(own_[pieces_[i - 1].firstPart]).material == first.material;
    if (continuesMesh) {
      ++files_.back().pieceCount;
    } else {
      files_.push_back(
          {"plant_" + std::to_string(first.plant) + " colour_" + std::to_string(first.material), first.material, i, 1});
    }
  }
  return std::nullopt;
}

// a piece for each shape in use, a mesh for each shape and material
void GlbWriter::planOrgans() {
  std::map<std::uint32_t, std::size_t> pieceOf;
  std::erase_if(
      organs_, [this](std::uint32_t i) { return meshes_.sharedMeshes()[meshes_.sharedMeshOf(part(i))].faces.empty(); });
  for (const std::uint32_t i : organs_) {
    const std::uint32_t shape = meshes_.sharedMeshOf(part(i));
    if (pieceOf.emplace(shape, pieces_.size()).second) {
      pieces_.push_back({});
      pieces_.back().add(meshes_.sharedMeshes()[shape]);
      shapes_.push_back(shape);
    }
    if (organMesh_.emplace(std::pair(shape, part(i).material), files_.size()).second) {
      files_.push_back({meshes_.sharedMeshName(shape) + " colour_" + std::to_string(part(i).material), part(i).material,
                        pieceOf[shape], 1});
    }
  }
}

void GlbWriter::planPlants() {
  std::map<std::uint32_t, PlantContent> content;
  for (std::size_t i = 0; i < files_.size() && files_[i].firstPiece < ownPieceCount_; ++i) {
    content[part(own_[pieces_[files_[i].firstPiece].firstPart]).plant].meshes.push_back(i);
  }
  for (std::size_t i = 0; i < organs_.size(); ++i) {
    PlantContent& plant = content[part(organs_[i]).plant];
    if (plant.organCount++ == 0) {
      plant.firstOrgan = i;
    }
  }
  std::size_t node = content.size();
  for (auto& [number, plant] : content) {
    plant.plant = number;
    plant.firstChild = node;
    node += plant.meshes.size() + plant.organCount;
    plants_.push_back(std::move(plant));
  }
  for (const FileMesh& mesh : files_) {
    materialIndex_.emplace(mesh.material, 0);
  }
  std::size_t index = 0;
  for (auto& material : materialIndex_) {
    material.second = index++;
  }
}

void GlbWriter::placePieces() {
  for (Piece& piece : pieces_) {
    piece.offset = binaryBytes_;
    binaryBytes_ += piece.bytes();
  }
}

// --- the text --------------------------------------------------------------------------------------------------------

void GlbWriter::writeOrganNode(const MeshPart& organ, TextOutput& out) const {
  const OrganPlacement placement = meshes_.placementOf(organ);
  const std::array<double, 4> q = *rotationOf(placement.frame);
  out << "{\"mesh\":";
  out.integer(static_cast<long long>(organMesh_.at({meshes_.sharedMeshOf(organ), organ.material})));
  (out << ",\"translation\":[").vector(placement.position, ',') << "],\"rotation\":[";
  for (std::size_t k = 0; k < 4; ++k) {
    (k == 0 ? out : out << ',').single(q[k]);
  }
  (out << "],\"scale\":[").vector(placement.scale, ',') << "],\"extras\":{\"module\":";
  out.integer(static_cast<long long>(meshes_.provenanceOf(organ).module)) << "}}";
}

void GlbWriter::writeNodes(TextOutput& out) const {
  out << "\"nodes\":[";
  for (std::size_t p = 0; p < plants_.size(); ++p) {
    const PlantContent& plant = plants_[p];
    out << (p == 0 ? "" : ",") << "{\"name\":\"plant_";
    out.integer(plant.plant) << "\",\"children\":[";
    const std::size_t children = plant.meshes.size() + plant.organCount;
    for (std::size_t k = 0; k < children; ++k) {
      (k == 0 ? out : out << ',').integer(static_cast<long long>(plant.firstChild + k));
    }
    out << "]}";
  }
  for (const PlantContent& plant : plants_) {
    for (const std::size_t mesh : plant.meshes) {
      out << ",{\"name\":\"" << files_[mesh].name << "\",\"mesh\":";
      out.integer(static_cast<long long>(mesh)) << '}';
    }
    for (std::size_t i = 0; i < plant.organCount; ++i) {
      out << ',';
      writeOrganNode(part(organs_[plant.firstOrgan + i]), out);
    }
  }
  out << "],\n";
}

void GlbWriter::writeMeshes(TextOutput& out) const {
  out << "\"meshes\":[";
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const FileMesh& mesh = files_[i];
    out << (i == 0 ? "" : ",") << "{\"name\":\"" << mesh.name << "\",\"primitives\":[";
    for (std::size_t k = 0; k < mesh.pieceCount; ++k) {
      const auto accessor = static_cast<long long>(4 * (mesh.firstPiece + k));
      out << (k == 0 ? "" : ",") << "{\"attributes\":{\"POSITION\":";
      out.integer(accessor) << ",\"NORMAL\":";
      out.integer(accessor + 1) << ",\"TEXCOORD_0\":";
      out.integer(accessor + 2) << "},\"indices\":";
      out.integer(accessor + 3) << ",\"material\":";
      out.integer(static_cast<long long>(materialIndex_.at(mesh.material))) << '}';
    }
    out << "]}";
  }
  out << "],\n";
}

void GlbWriter::writeMaterials(TextOutput& out) const {
  out << "\"materials\":[";
  bool isFirst = true;
  for (const auto& [number, index] : materialIndex_) {
    const Colour colour = meshes_.palette().ofMaterial(number);
    Vec3 base{colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0};
    double opacity = 1.0;
    double roughness = kDefaultRoughness;
    Vec3 emission;
    const std::optional<language::Material> own = meshes_.palette().folderMaterial(number);
    if (own) {
      base = {own->diffuse[0], own->diffuse[1], own->diffuse[2]};
      emission = {own->emission[0], own->emission[1], own->emission[2]};
      opacity = std::clamp(own->opacity, 0.0, 1.0);
      // the width of a highlight with that exponent
      roughness = std::clamp(std::sqrt(2.0 / (own->shininess + 2.0)), 0.0, 1.0);
    }
    const auto factor = [](const Vec3& v) { return Vec3{linear(v.x), linear(v.y), linear(v.z)}; };
    out << (isFirst ? "" : ",") << "{\"name\":\"colour_";
    isFirst = false;
    (out.integer(number) << "\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[").vector(factor(base), ',') << ',';
    (out.single(opacity) << "],\"metallicFactor\":0,\"roughnessFactor\":").single(roughness) << '}';
    if (emission != Vec3{}) {
      (out << ",\"emissiveFactor\":[").vector(factor(emission), ',') << ']';
    }
    out << (opacity < 1.0 ? ",\"alphaMode\":\"BLEND\"" : "") << ",\"doubleSided\":true}";
  }
  out << "],\n";
}

void GlbWriter::writeAccessors(TextOutput& out) const {
  // three attributes and the indices of each piece
  struct Attribute {
    std::uint64_t offset;
    std::string_view type;
  };
  constexpr std::array<Attribute, 3> kAttributes{{{0, "VEC3"}, {12, "VEC3"}, {24, "VEC2"}}};
  out << "\"accessors\":[";
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    for (std::size_t k = 0; k < kAttributes.size(); ++k) {
      out << (i + k == 0 ? "" : ",") << "{\"bufferView\":";
      out.integer(static_cast<long long>(2 * i)) << ",\"byteOffset\":";
      out.integer(static_cast<long long>(kAttributes[k].offset)) << ",\"componentType\":5126,\"count\":";
      out.integer(static_cast<long long>(piece.vertexCount)) << ",\"type\":\"" << kAttributes[k].type << '"';
      if (k == 0) {
        (out << ",\"min\":[").vector(piece.bounds.low, ',') << ']';
        (out << ",\"max\":[").vector(piece.bounds.high, ',') << ']';
      }
      out << '}';
    }
    out << ",{\"bufferView\":";
    out.integer(static_cast<long long>(2 * i + 1)) << ",\"componentType\":5125,\"count\":";
    out.integer(static_cast<long long>(piece.indexCount)) << ",\"type\":\"SCALAR\"}";
  }
  out << "],\n";
}

void GlbWriter::writeBufferViews(TextOutput& out) const {
  out << "\"bufferViews\":[";
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    const std::uint64_t vertexBytes = piece.vertexCount * kVertexBytes;
    out << (i == 0 ? "" : ",") << "{\"buffer\":0,\"byteOffset\":";
    out.integer(static_cast<long long>(piece.offset)) << ",\"byteLength\":";
    out.integer(static_cast<long long>(vertexBytes))
        << ",\"byteStride\":32,\"target\":34962},{\"buffer\":0,\"byteOffset\":";
    out.integer(static_cast<long long>(piece.offset + vertexBytes)) << ",\"byteLength\":";
    out.integer(static_cast<long long>(piece.indexCount * kIndexBytes)) << ",\"target\":34963}";
  }
  out << "],\n";
}

void GlbWriter::writeJson(core::ByteSink& sink) const {
  TextOutput out(sink);
  out << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Espalier\"},\n\"scene\":0,\n";
  if (plants_.empty()) {
    out << "\"scenes\":[{\"name\":\"empty\"}]}";
    return;
  }
  writeNodes(out);
  writeMeshes(out);
  writeMaterials(out);
  writeAccessors(out);
  writeBufferViews(out);
  out << "\"buffers\":[{\"byteLength\":";
  out.integer(static_cast<long long>(binaryBytes_)) << "}],\n\"scenes\":[{\"nodes\":[";
  for (std::size_t p = 0; p < plants_.size(); ++p) {
    (p == 0 ? out : out << ',').integer(static_cast<long long>(p));
  }
  out << "]}]}";
}

// --- the numbers -----------------------------------------------------------------------------------------------------

void GlbWriter::writeVertices(const Mesh& mesh, BinaryOutput& out) const {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    out.vector(mesh.positions[i]);
    out.vector(unitNormal(mesh.normals[i]));
    out.single(mesh.coordinates[i][0]);
    out.single(1.0 - mesh.coordinates[i][1]);  // glTF has v downward
  }
}

void GlbWriter::appendIndices(const Mesh& mesh, std::uint32_t first, std::vector<std::uint32_t>& indices) {
  for (const auto& face : mesh.faces) {
    indices.insert(indices.end(), {first + face[0], first + face[1], first + face[2]});
    if (face[3] != Mesh::kNoVertex) {
      indices.insert(indices.end(), {first + face[0], first + face[2], first + face[3]});
    }
  }
}

void GlbWriter::writePieces() {
  BinaryOutput out(target_.sink);
  Mesh mesh;
  std::vector<std::uint32_t> indices;
  const auto writeIndices = [&] {
    for (const std::uint32_t index : indices) {
      out.uint32(index);
    }
    indices.clear();
  };
  for (std::size_t i = 0; i < ownPieceCount_; ++i) {
    const Piece& piece = pieces_[i];
    std::uint32_t first = 0;
    for (std::size_t k = piece.firstPart; k < piece.firstPart + piece.partCount; ++k) {
      meshes_.make(part(own_[k]), mesh);
      writeVertices(mesh, out);
      appendIndices(mesh, first, indices);
      first += static_cast<std::uint32_t>(mesh.positions.size());
      report(own_.size() + k + 1);
    }
    writeIndices();
  }
  for (const std::uint32_t shape : shapes_) {
    writeVertices(meshes_.sharedMeshes()[shape], out);
    appendIndices(meshes_.sharedMeshes()[shape], 0, indices);
    writeIndices();
  }
}

std::optional<std::string> GlbWriter::write() {
  sortParts();
  if (auto problem = measurePieces()) {
    return problem;
  }
  planOrgans();
  planPlants();
  placePieces();

  // header, text padded by blanks, numbers
  CountingSink counter;
  writeJson(counter);
  const std::uint64_t jsonBytes = (counter.count() + 3) / 4 * 4;
  const bool hasBinary = binaryBytes_ > 0;
  const std::uint64_t fileBytes = 12 + 8 + jsonBytes + (hasBinary ? 8 + binaryBytes_ : 0);
  if (fileBytes > std::numeric_limits<std::uint32_t>::max()) {
    return "it would have " + std::to_string(fileBytes / 1'000'000) +
           " MB and the format holds at most 4294 MB. Write .ply or .obj, or fewer contour sides";
  }
  {
    BinaryOutput out(target_.sink);
    out.bytes("glTF");
    out.uint32(2);
    out.uint32(static_cast<std::uint32_t>(fileBytes));
    out.uint32(static_cast<std::uint32_t>(jsonBytes));
    out.bytes("JSON");
  }
  writeJson(target_.sink);
  {
    BinaryOutput out(target_.sink);
    out.bytes(std::string(jsonBytes - counter.count(), ' '));
    if (hasBinary) {
      out.uint32(static_cast<std::uint32_t>(binaryBytes_));
      out.bytes(std::string_view("BIN\0", 4));
    }
  }
  writePieces();
  return std::nullopt;
}

}  // namespace

std::optional<std::string> exportGlb(const ExportInput& input, const ExportTarget& target) {
  return GlbWriter(input, target).write();
}

}  // namespace espalier::turtle
