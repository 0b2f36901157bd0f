#include "engine/turtle/export/glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/turtle/export/binary_output.h"
#include "engine/turtle/export/mesh_check.h"
#include "engine/turtle/export/mesh_rounds.h"
#include "engine/turtle/export/placed_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::uint64_t kVertexBytes = 32;  // position, normal, texture coordinates
constexpr std::uint64_t kIndexBytes = 4;
constexpr std::uint64_t kInstanceBytes = 40;         // translation, rotation, scale
constexpr std::uint64_t kPieceVertices = 1'000'000;  // about: pieces end with a part
constexpr std::size_t kMostOrganNodes = 100'000;     // viewers take no more; beyond, organs become part of the meshes
constexpr double kDefaultRoughness = 0.8;

/// A run of parts of one scene that becomes one primitive: vertices and indices that follow each other in the file.
struct Piece {
  std::uint32_t material = 0;
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

/// A mesh of the file: the pieces of one material of a plant, a shape that organs share in one material, or all of a
/// scene that is placed several times.
struct FileMesh {
  std::string name;
  std::size_t firstPiece = 0;
  std::size_t pieceCount = 1;
  std::optional<std::uint32_t> material = {};  // of a shape, whose piece is the same in every material
};

/// One part of one scene.
struct PartOf {
  std::uint32_t scene = 0;
  std::uint32_t part = 0;
};

/// A plant of a copy, and what stands below its node.
struct PlantNode {
  std::uint32_t plant = 0;  // among all copies
  const ScenePlacement* placement = nullptr;
  std::optional<std::size_t> ownMesh = {};  // of a scene that is placed several times; nothing stands below then
  std::vector<std::size_t> meshes = {};     // into the file's meshes
  std::size_t firstOrgan = 0;               // into the parts drawn as nodes
  std::size_t organCount = 0;
  std::size_t firstChild = 0;  // node
};

/// Consecutive items of a list that belong to one scene.
struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;

  /// Adds the next item of the list.
  void add(std::size_t index) {
    begin = begin == end ? index : begin;
    end = index + 1;
  }
};

/// Copies of one mesh that stand in one node by EXT_mesh_gpu_instancing.
struct InstanceNode {
  std::size_t mesh = 0;
  std::vector<const ScenePlacement*> placements;
};

class CountingSink final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override { count_ += bytes.size(); }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  std::uint64_t count_ = 0;
};

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

/// The range of a table of the binary chunk behind the meshes: instances and pictures.
struct Block {
  std::uint64_t offset = 0;
  std::uint64_t byteCount = 0;
};

class GlbWriter {
 public:
  GlbWriter(const PlacedScenes& placed, const ExportTarget& target)
      : meshes_(placed), target_(target), usesInstancing_(placed.scenes[0].usesInstancing) {}

  [[nodiscard]] std::optional<std::string> write();

 private:
  // the plan: what is in the file, without its meshes
  void sortParts();
  [[nodiscard]] std::optional<std::string> measurePieces();
  void nameMeshes();
  void planOrgans();
  void planNodes();
  void placeBlocks();
  [[nodiscard]] bool isRepeated(std::uint32_t scene) const { return copyCount_[scene] > 1; }
  void planPlants(const SceneCopy& copy);
  [[nodiscard]] std::uint32_t materialOf(const FileMesh& mesh, std::size_t piece) const;
  [[nodiscard]] bool sharesMesh(const PartOf& a, const PartOf& b) const;

  // the text
  void writeJson(core::ByteSink& sink) const;
  void writeNodes(TextOutput& out) const;
  void writeOrganNode(const PartOf& organ, TextOutput& out) const;
  void writeInstanceNode(std::size_t index, TextOutput& out) const;
  void writeMeshes(TextOutput& out) const;
  void writeMaterials(TextOutput& out) const;
  void writeTextures(TextOutput& out) const;
  void writeAccessors(TextOutput& out) const;
  void writeBufferViews(TextOutput& out) const;

  // the numbers
  [[nodiscard]] std::optional<std::string> writePieces();
  void writeInstances(BinaryOutput& out) const;
  void writePictures(BinaryOutput& out) const;
  void writeVertices(const Mesh& mesh, BinaryOutput& out) const;
  static void appendIndices(const Mesh& mesh, std::uint32_t first, std::vector<std::uint32_t>& indices);

  [[nodiscard]] const SceneMeshes& sceneOf(const PartOf& part) const { return meshes_.scene(part.scene); }
  [[nodiscard]] const MeshPart& partOf(const PartOf& part) const { return sceneOf(part).parts()[part.part]; }
  void report(std::size_t done) { reportProgress(target_.progress, done, 2 * own_.size()); }

  PlacedMeshes meshes_;
  const ExportTarget& target_;
  bool usesInstancing_;
  std::vector<std::uint32_t> copyCount_;  // by scene
  std::vector<PartOf> own_;               // parts with vertices of their own, by scene, plant and material
  std::vector<PartOf> organs_;            // parts drawn as nodes, by scene and plant
  std::vector<Piece> pieces_;             // own ones, then the shared shapes in use
  std::size_t ownPieceCount_ = 0;
  std::vector<FileMesh> files_;
  std::vector<Range> filesOf_, organsOf_;                             // own meshes and organs by scene
  using Shape = std::pair<std::uint32_t, std::uint32_t>;              // of a scene
  std::map<std::pair<Shape, std::uint32_t>, std::size_t> organMesh_;  // by shape and material
  std::vector<Shape> shapes_;                                         // of the shared pieces, in order
  std::vector<PlantNode> plants_;
  std::vector<InstanceNode> instances_;
  std::vector<Block> instanceBlocks_, pictureBlocks_;
  std::map<std::uint32_t, std::size_t> materialIndex_, textureIndex_;  // in the file, of those of the table in use
  std::uint64_t binaryBytes_ = 0;
};

void GlbWriter::sortParts() {
  copyCount_.assign(meshes_.sceneCount(), 0);
  for (const SceneCopy& copy : meshes_.copies()) {
    ++copyCount_[copy.scene];
  }
  std::size_t sharedCount = 0;
  const auto isShared = [](const SceneMeshes& scene, const MeshPart& part) {
    return scene.sharedMeshOf(part) != SceneMeshes::kNotShared;
  };
  for (std::uint32_t s = 0; s < meshes_.sceneCount(); ++s) {
    const SceneMeshes& scene = meshes_.scene(s);
    sharedCount += copyCount_[s] == 1 ? static_cast<std::size_t>(std::ranges::count_if(
                                            scene.parts(), [&](const MeshPart& p) { return isShared(scene, p); }))
                                      : 0;
  }
  const bool hasNodes = sharedCount <= kMostOrganNodes;
  for (std::uint32_t s = 0; s < meshes_.sceneCount(); ++s) {
    const SceneMeshes& scene = meshes_.scene(s);
    const std::span<const MeshPart> parts = scene.parts();
    for (std::uint32_t i = 0; copyCount_[s] > 0 && i < parts.size(); ++i) {
      // of a scene that is placed several times the whole is the shared mesh
      const bool isNode =
          copyCount_[s] == 1 && hasNodes && isShared(scene, parts[i]) && fitsNode(scene.placementOf(parts[i]));
      (isNode ? organs_ : own_).push_back({s, i});
    }
  }
  std::ranges::stable_sort(own_, {}, [this](const PartOf& p) {
    return std::tuple(p.scene, isRepeated(p.scene) ? 0 : partOf(p).plant, partOf(p).material);
  });
}

// whether two neighbours in the order are in one mesh of the file
bool GlbWriter::sharesMesh(const PartOf& a, const PartOf& b) const {
  return a.scene == b.scene &&
         (isRepeated(a.scene) || (partOf(a).plant == partOf(b).plant && partOf(a).material == partOf(b).material));
}

std::optional<std::string> GlbWriter::measurePieces() {
  const auto make = [this](std::size_t i, Mesh& mesh) { sceneOf(own_[i]).make(partOf(own_[i]), mesh); };
  auto problem = forMeshes(meshes_.team(), own_.size(), make, [&](std::size_t i, const Mesh& mesh) {
    const MeshPart& next = partOf(own_[i]);
    report(i + 1);
    auto wrong = problemOf(mesh, sceneOf(own_[i]).input(), sceneOf(own_[i]).provenanceOf(next));
    const bool continuesPiece =
        i > 0 && sharesMesh(own_[i - 1], own_[i]) && partOf(own_[i - 1]).material == next.material;
    if (!continuesPiece || pieces_.back().vertexCount >= kPieceVertices) {
      pieces_.push_back({.material = next.material, .firstPart = i});
    }
    ++pieces_.back().partCount;
    pieces_.back().add(mesh);
    return wrong;
  });
  // lines without length or polygons without three corners have no mesh
  std::erase_if(pieces_, [](const Piece& piece) { return piece.indexCount == 0; });
  ownPieceCount_ = pieces_.size();
  return problem;
}

void GlbWriter::nameMeshes() {
  filesOf_.resize(meshes_.sceneCount());
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const PartOf& first = own_[pieces_[i].firstPart];
    if (i > 0 && sharesMesh(own_[pieces_[i - 1].firstPart], first)) {
      ++files_.back().pieceCount;
      continue;
    }
    const std::string name = isRepeated(first.scene) ? "scene_" + std::to_string(first.scene)
                                                     : "plant_" + std::to_string(partOf(first).plant) + " " +
                                                           meshes_.materials()[pieces_[i].material].name;
    filesOf_[first.scene].add(files_.size());
    files_.push_back({name, i, 1});
  }
}

// a piece for each shape in use, a mesh for each shape and material
void GlbWriter::planOrgans() {
  std::erase_if(organs_, [this](const PartOf& p) {
    return sceneOf(p).sharedMeshes()[sceneOf(p).sharedMeshOf(partOf(p))].faces.empty();
  });
  organsOf_.resize(meshes_.sceneCount());
  std::map<Shape, std::size_t> pieceOf;
  for (std::size_t i = 0; i < organs_.size(); ++i) {
    const PartOf& organ = organs_[i];
    organsOf_[organ.scene].add(i);
    const Shape shape{organ.scene, sceneOf(organ).sharedMeshOf(partOf(organ))};
    const std::uint32_t material = partOf(organ).material;
    if (pieceOf.emplace(shape, pieces_.size()).second) {
      pieces_.push_back({});
      pieces_.back().add(sceneOf(organ).sharedMeshes()[shape.second]);
      shapes_.push_back(shape);
    }
    if (organMesh_.emplace(std::pair(shape, material), files_.size()).second) {
      files_.push_back({sceneOf(organ).sharedMeshName(shape.second) + " " + meshes_.materials()[material].name,
                        pieceOf[shape], 1, material});
    }
  }
}

void GlbWriter::planNodes() {
  std::map<std::uint32_t, std::size_t> instanceOf;  // by scene
  for (const SceneCopy& copy : meshes_.copies()) {
    const Range& files = filesOf_[copy.scene];
    if (!isRepeated(copy.scene)) {
      planPlants(copy);
    } else if (files.begin < files.end && usesInstancing_) {
      if (instanceOf.emplace(copy.scene, instances_.size()).second) {
        instances_.push_back({files.begin, {}});
      }
      instances_[instanceOf[copy.scene]].placements.push_back(&copy.placement);
    } else if (files.begin < files.end) {
      plants_.push_back({.plant = copy.firstPlant, .placement = &copy.placement, .ownMesh = files.begin});
    }
  }
  // plants, then instances, then what stands below the plants
  std::size_t node = plants_.size() + instances_.size();
  for (PlantNode& plant : plants_) {
    plant.firstChild = node;
    node += plant.meshes.size() + plant.organCount;
  }
}

// the plants of a scene that is placed once
void GlbWriter::planPlants(const SceneCopy& copy) {
  std::map<std::uint32_t, PlantNode> content;
  for (std::size_t i = filesOf_[copy.scene].begin; i < filesOf_[copy.scene].end; ++i) {
    content[partOf(own_[pieces_[files_[i].firstPiece].firstPart]).plant].meshes.push_back(i);
  }
  for (std::size_t i = organsOf_[copy.scene].begin; i < organsOf_[copy.scene].end; ++i) {
    PlantNode& plant = content[partOf(organs_[i]).plant];
    plant.firstOrgan = plant.organCount++ == 0 ? i : plant.firstOrgan;
  }
  for (auto& [number, plant] : content) {
    plant.plant = copy.firstPlant + number;
    plant.placement = &copy.placement;
    plants_.push_back(std::move(plant));
  }
}

std::uint32_t GlbWriter::materialOf(const FileMesh& mesh, std::size_t piece) const {
  return mesh.material.value_or(pieces_[piece].material);
}

void GlbWriter::placeBlocks() {
  for (Piece& piece : pieces_) {
    piece.offset = binaryBytes_;
    binaryBytes_ += piece.bytes();
  }
  for (const InstanceNode& node : instances_) {
    instanceBlocks_.push_back({binaryBytes_, node.placements.size() * kInstanceBytes});
    binaryBytes_ += instanceBlocks_.back().byteCount;
  }
  for (const FileMesh& mesh : files_) {
    for (std::size_t k = 0; k < mesh.pieceCount; ++k) {
      materialIndex_.emplace(materialOf(mesh, mesh.firstPiece + k), 0);
    }
  }
  std::size_t index = 0;
  for (auto& material : materialIndex_) {
    material.second = index++;
    const std::uint32_t texture = meshes_.materials()[material.first].texture;
    if (texture != MeshMaterial::kNoTexture) {
      textureIndex_.emplace(texture, 0);
    }
  }
  index = 0;
  for (auto& [texture, number] : textureIndex_) {
    number = index++;
    const std::uint64_t bytes = meshes_.textures()[texture].fileBytes().size();
    pictureBlocks_.push_back({binaryBytes_, bytes});
    binaryBytes_ += (bytes + 3) / 4 * 4;
  }
}

// --- the text --------------------------------------------------------------------------------------------------------

void writePlacement(const ScenePlacement& placement, TextOutput& out) {
  if (placement.isIdentity()) {
    return;
  }
  (out << ",\"translation\":[").vector(placement.position, ',') << "],\"rotation\":[0,";
  out.single(std::sin(0.5 * placement.turnRadians)) << ",0,";
  out.single(std::cos(0.5 * placement.turnRadians)) << "],\"scale\":[";
  out.vector({placement.scale, placement.scale, placement.scale}, ',') << ']';
}

void GlbWriter::writeOrganNode(const PartOf& organ, TextOutput& out) const {
  const SceneMeshes& scene = sceneOf(organ);
  const MeshPart& part = partOf(organ);
  const OrganPlacement placement = scene.placementOf(part);
  const std::array<double, 4> q = *rotationOf(placement.frame);
  out << "{\"mesh\":";
  const Shape shape{organ.scene, scene.sharedMeshOf(part)};
  out.integer(static_cast<long long>(organMesh_.at({shape, part.material})));
  (out << ",\"translation\":[").vector(placement.position, ',') << "],\"rotation\":[";
  for (std::size_t k = 0; k < 4; ++k) {
    (k == 0 ? out : out << ',').single(q[k]);
  }
  (out << "],\"scale\":[").vector(placement.scale, ',') << "],\"extras\":{\"module\":";
  out.integer(static_cast<long long>(scene.provenanceOf(part).module)) << "}}";
}

// accessors of instances follow those of the pieces
void GlbWriter::writeInstanceNode(std::size_t index, TextOutput& out) const {
  const std::size_t first = 4 * pieces_.size() + 3 * index;
  out << "{\"name\":\"" << files_[instances_[index].mesh].name << "\",\"mesh\":";
  out.integer(static_cast<long long>(instances_[index].mesh))
      << ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":";
  out.integer(static_cast<long long>(first)) << ",\"ROTATION\":";
  out.integer(static_cast<long long>(first + 1)) << ",\"SCALE\":";
  out.integer(static_cast<long long>(first + 2)) << "}}}}";
}

void GlbWriter::writeNodes(TextOutput& out) const {
  out << "\"nodes\":[";
  for (std::size_t p = 0; p < plants_.size(); ++p) {
    const PlantNode& plant = plants_[p];
    out << (p == 0 ? "" : ",") << "{\"name\":\"plant_";
    out.integer(plant.plant) << '"';
    writePlacement(*plant.placement, out);
    if (plant.ownMesh) {
      (out << ",\"mesh\":").integer(static_cast<long long>(*plant.ownMesh)) << '}';
      continue;
    }
    out << ",\"children\":[";
    const std::size_t children = plant.meshes.size() + plant.organCount;
    for (std::size_t k = 0; k < children; ++k) {
      (k == 0 ? out : out << ',').integer(static_cast<long long>(plant.firstChild + k));
    }
    out << "]}";
  }
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    out << (i + plants_.size() == 0 ? "" : ",");
    writeInstanceNode(i, out);
  }
  for (const PlantNode& plant : plants_) {
    for (const std::size_t mesh : plant.meshes) {
      out << ",{\"name\":\"" << files_[mesh].name << "\",\"mesh\":";
      out.integer(static_cast<long long>(mesh)) << '}';
    }
    for (std::size_t i = 0; i < plant.organCount; ++i) {
      out << ',';
      writeOrganNode(organs_[plant.firstOrgan + i], out);
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
      out.integer(static_cast<long long>(materialIndex_.at(materialOf(mesh, mesh.firstPiece + k)))) << '}';
    }
    out << "]}";
  }
  out << "],\n";
}

void GlbWriter::writeMaterials(TextOutput& out) const {
  out << "\"materials\":[";
  bool isFirst = true;
  for (const auto& [number, index] : materialIndex_) {
    const MeshMaterial& material = meshes_.materials()[number];
    const bool isTextured = material.texture != MeshMaterial::kNoTexture;
    const MeshTexture* const texture = isTextured ? &meshes_.textures()[material.texture] : nullptr;
    const bool isCovered = isTextured && texture->texture->use == language::Texture::Use::Decal;
    const std::array<double, 3> diffuse = isCovered ? std::array{1.0, 1.0, 1.0} : material.diffuse();
    double roughness = kDefaultRoughness;
    Vec3 emission;
    if (material.folder) {
      emission = {material.folder->emission[0], material.folder->emission[1], material.folder->emission[2]};
      // the width of a highlight with that exponent
      roughness = std::clamp(std::sqrt(2.0 / (material.folder->shininess + 2.0)), 0.0, 1.0);
    }
    const auto factor = [](double x, double y, double z) {
      return Vec3{linearComponent(x), linearComponent(y), linearComponent(z)};
    };
    out << (isFirst ? "" : ",") << "{\"name\":\"" << material.name
        << "\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[";
    isFirst = false;
    const double opacity = std::clamp(material.opacity(), 0.0, 1.0);
    out.vector(factor(diffuse[0], diffuse[1], diffuse[2]), ',') << ',';
    (out.single(opacity) << "],\"metallicFactor\":0,\"roughnessFactor\":").single(roughness);
    if (isTextured) {
      (out << ",\"baseColorTexture\":{\"index\":").integer(static_cast<long long>(textureIndex_.at(material.texture)))
          << '}';
    }
    out << '}';
    if (emission != Vec3{}) {
      (out << ",\"emissiveFactor\":[").vector(factor(emission.x, emission.y, emission.z), ',') << ']';
    }
    // holes are cut out, so that nothing need be sorted
    const bool hasHoles = isTextured && opacity == 1.0 && texture->hasHoles();
    out << (opacity < 1.0 ? ",\"alphaMode\":\"BLEND\""
            : hasHoles    ? ",\"alphaMode\":\"MASK\""
                          : "")
        << ",\"doubleSided\":true}";
  }
  out << "],\n";
}

void GlbWriter::writeTextures(TextOutput& out) const {
  if (textureIndex_.empty()) {
    return;
  }
  // glTF's numbers of the filters, by the words of view files
  const auto minification = [](std::string_view word) {
    constexpr std::array<std::pair<std::string_view, int>, 6> kFilters{
        {{"n", 9728}, {"l", 9729}, {"mnn", 9984}, {"mln", 9985}, {"mnl", 9986}, {"mll", 9987}}};
    return std::ranges::find(kFilters, word, &std::pair<std::string_view, int>::first)->second;
  };
  const auto list = [this, &out](std::string_view name, const auto& write) {
    out << '"' << name << "\":[";
    for (auto at = textureIndex_.begin(); at != textureIndex_.end(); ++at) {
      out << (at == textureIndex_.begin() ? "{" : ",{");
      write(meshes_.textures()[at->first], static_cast<long long>(at->second));
      out << '}';
    }
    out << "],\n";
  };
  list("textures", [&out](const MeshTexture& texture, long long index) {
    (out << "\"name\":\"" << texture.name << "\",\"sampler\":").integer(index) << ",\"source\":";
    out.integer(index);
  });
  list("samplers", [&](const MeshTexture& texture, long long) {
    (out << "\"magFilter\":").integer(texture.texture->isSmoothNear ? 9729 : 9728) << ",\"minFilter\":";
    out.integer(minification(texture.texture->minification));
  });
  list("images", [&](const MeshTexture& texture, long long index) {
    const std::size_t view = 2 * pieces_.size() + instances_.size() + static_cast<std::size_t>(index);
    (out << "\"name\":\"" << texture.name << "\",\"mimeType\":\""
         << (texture.suffix() == ".jpg" ? "image/jpeg" : "image/png") << "\",\"bufferView\":")
        .integer(static_cast<long long>(view));
  });
}

void GlbWriter::writeAccessors(TextOutput& out) const {
  struct Attribute {
    std::uint64_t offset;
    std::string_view type;
  };
  const auto writeAccessor = [&out](std::size_t view, const Attribute& attribute, int componentType,
                                    std::uint64_t count) {
    out << "{\"bufferView\":";
    out.integer(static_cast<long long>(view)) << ",\"byteOffset\":";
    out.integer(static_cast<long long>(attribute.offset)) << ",\"componentType\":";
    out.integer(componentType) << ",\"count\":";
    out.integer(static_cast<long long>(count)) << ",\"type\":\"" << attribute.type << '"';
  };
  constexpr int kFloat = 5126;
  constexpr int kUnsigned = 5125;
  // three attributes and the indices of each piece
  constexpr std::array<Attribute, 3> kAttributes{{{0, "VEC3"}, {12, "VEC3"}, {24, "VEC2"}}};
  out << "\"accessors\":[";
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    for (std::size_t k = 0; k < kAttributes.size(); ++k) {
      out << (i + k == 0 ? "" : ",");
      writeAccessor(2 * i, kAttributes[k], kFloat, piece.vertexCount);
      if (k == 0) {
        (out << ",\"min\":[").vector(piece.bounds.low, ',') << ']';
        (out << ",\"max\":[").vector(piece.bounds.high, ',') << ']';
      }
      out << '}';
    }
    out << ',';
    writeAccessor(2 * i + 1, {0, "SCALAR"}, kUnsigned, piece.indexCount);
    out << '}';
  }
  // translation, rotation and scale of instances, one after the other
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    const std::uint64_t count = instances_[i].placements.size();
    constexpr std::array<std::pair<std::uint64_t, std::string_view>, 3> kTables{
        {{0, "VEC3"}, {12, "VEC4"}, {28, "VEC3"}}};
    for (const auto& [bytesBefore, type] : kTables) {
      out << ',';
      writeAccessor(2 * pieces_.size() + i, {bytesBefore * count, type}, kFloat, count);
      out << '}';
    }
  }
  out << "],\n";
}

void GlbWriter::writeBufferViews(TextOutput& out) const {
  const auto writeView = [&out](std::uint64_t offset, std::uint64_t byteCount) {
    out << "{\"buffer\":0,\"byteOffset\":";
    out.integer(static_cast<long long>(offset)) << ",\"byteLength\":";
    out.integer(static_cast<long long>(byteCount));
  };
  out << "\"bufferViews\":[";
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const Piece& piece = pieces_[i];
    const std::uint64_t vertexBytes = piece.vertexCount * kVertexBytes;
    out << (i == 0 ? "" : ",");
    writeView(piece.offset, vertexBytes);
    out << ",\"byteStride\":32,\"target\":34962},";
    writeView(piece.offset + vertexBytes, piece.indexCount * kIndexBytes);
    out << ",\"target\":34963}";
  }
  for (const auto* blocks : {&instanceBlocks_, &pictureBlocks_}) {
    for (const Block& block : *blocks) {
      out << ',';
      writeView(block.offset, block.byteCount);
      out << '}';
    }
  }
  out << "],\n";
}

void GlbWriter::writeJson(core::ByteSink& sink) const {
  TextOutput out(sink);
  out << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Espalier\"},\n\"scene\":0,\n";
  const std::size_t rootCount = plants_.size() + instances_.size();
  if (rootCount == 0) {
    out << "\"scenes\":[{\"name\":\"empty\"}]}";
    return;
  }
  if (!instances_.empty()) {
    out << "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\n\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"],\n";
  }
  writeNodes(out);
  writeMeshes(out);
  writeMaterials(out);
  writeTextures(out);
  writeAccessors(out);
  writeBufferViews(out);
  out << "\"buffers\":[{\"byteLength\":";
  out.integer(static_cast<long long>(binaryBytes_)) << "}],\n\"scenes\":[{\"nodes\":[";
  for (std::size_t p = 0; p < rootCount; ++p) {
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

std::optional<std::string> GlbWriter::writePieces() {
  BinaryOutput out(target_.sink);
  std::vector<std::uint32_t> indices;
  const auto writeIndices = [&] {
    for (const std::uint32_t index : indices) {
      out.uint32(index);
    }
    indices.clear();
  };
  // the parts of pieces, without those of pieces that have no triangles
  std::vector<std::size_t> order;
  order.reserve(own_.size());
  for (std::size_t i = 0; i < ownPieceCount_; ++i) {
    for (std::size_t k = 0; k < pieces_[i].partCount; ++k) {
      order.push_back(pieces_[i].firstPart + k);
    }
  }
  std::size_t piece = 0;
  std::uint32_t first = 0;
  const auto make = [&](std::size_t i, Mesh& mesh) { sceneOf(own_[order[i]]).make(partOf(own_[order[i]]), mesh); };
  const auto write = [&](std::size_t i, const Mesh& mesh) -> std::optional<std::string> {
    writeVertices(mesh, out);
    appendIndices(mesh, first, indices);
    first += static_cast<std::uint32_t>(mesh.positions.size());
    if (order[i] + 1 == pieces_[piece].firstPart + pieces_[piece].partCount) {
      writeIndices();
      first = 0;
      ++piece;
    }
    report(own_.size() + order[i] + 1);
    return std::nullopt;
  };
  if (auto problem = forMeshes(meshes_.team(), order.size(), make, write)) {
    return problem;
  }
  for (const auto& [scene, shape] : shapes_) {
    const Mesh& mesh = meshes_.scene(scene).sharedMeshes()[shape];
    writeVertices(mesh, out);
    appendIndices(mesh, 0, indices);
    writeIndices();
  }
  writeInstances(out);
  writePictures(out);
  return std::nullopt;
}

void GlbWriter::writeInstances(BinaryOutput& out) const {
  for (const InstanceNode& node : instances_) {
    for (const ScenePlacement* placement : node.placements) {
      out.vector(placement->position);
    }
    for (const ScenePlacement* placement : node.placements) {
      out.vector({0.0, std::sin(0.5 * placement->turnRadians), 0.0});
      out.single(std::cos(0.5 * placement->turnRadians));
    }
    for (const ScenePlacement* placement : node.placements) {
      out.vector({placement->scale, placement->scale, placement->scale});
    }
  }
}

void GlbWriter::writePictures(BinaryOutput& out) const {
  for (const auto& [texture, index] : textureIndex_) {
    std::string bytes = meshes_.textures()[texture].fileBytes();
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    out.bytes(bytes);
  }
}

std::optional<std::string> GlbWriter::write() {
  sortParts();
  if (auto problem = measurePieces()) {
    return problem;
  }
  nameMeshes();
  planOrgans();
  planNodes();
  placeBlocks();

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
  return writePieces();
}

}  // namespace

std::optional<std::string> exportGlb(const PlacedScenes& placed, const ExportTarget& target) {
  return GlbWriter(placed, target).write();
}

}  // namespace espalier::turtle
