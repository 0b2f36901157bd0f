#include "engine/turtle/export/mesh/glb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/export/binary_output.h"
#include "engine/turtle/export/ground_contact.h"
#include "engine/turtle/export/mesh/glb_plan.h"
#include "engine/turtle/export/mesh/mesh_work.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

// highlights of grey 0.5, as a screen shows it, reflect 4 % of the light, as materials of glTF without the extension do
constexpr double kUsualReflection = 1.0 / 0.214041;
constexpr double kDefaultRoughness = 0.8;

using GroundContacts = std::vector<GroundContact>;

/// Finds where the plants of each scene stand, on a thread of its own if there may be one.
std::future<std::vector<GroundContacts>> findGround(std::span<const ExportInput> scenes) {
  const bool isAlone = scenes.empty() || scenes.front().threads <= 1;
  return std::async(isAlone ? std::launch::deferred : std::launch::deferred | std::launch::async,
                    [scenes, meter = core::WorkMeter::current()] {
                      const core::WorkMeter::Scope scope(meter);
                      std::vector<GroundContacts> contacts;
                      for (const ExportInput& input : scenes) {
                        contacts.push_back(groundContactsOf(input.scene));
                      }
                      return contacts;
                    });
}

class GlbWriter {
 public:
  GlbWriter(const PlacedScenes& placed, const ExportTarget& target)
      : ground_(findGround(placed.scenes)), plan_(placed), target_(target) {}

  [[nodiscard]] std::optional<std::string> write();

 private:
  // the text
  [[nodiscard]] std::string jsonText();
  void writeNodes(TextOutput& out) const;
  void writeInstanceNode(std::size_t index, TextOutput& out) const;
  void writeMeshes(TextOutput& out) const;
  void writeMaterials(TextOutput& out) const;
  void writeTextures(TextOutput& out) const;
  void writeAccessors(TextOutput& out) const;
  void writeBufferViews(TextOutput& out) const;
  void writeGround(TextOutput& out);

  // the numbers
  [[nodiscard]] std::optional<std::string> writePieces();
  void writeInstances(BinaryOutput& out) const;
  void writePictures(BinaryOutput& out) const;
  static void writeVertices(const Mesh& mesh, bool hasCoordinates, BinaryOutput& out);
  static void writeIndices(const Mesh& mesh, std::uint32_t first, BinaryOutput& out);

  void report(std::size_t done) { reportProgress(target_.progress, done, 2 * plan_.own.size()); }

  std::future<std::vector<GroundContacts>> ground_;  // by scene
  GlbPlan plan_;
  const ExportTarget& target_;
};

// --- the text --------------------------------------------------------------------------------------------------------

void writePlacement(const ScenePlacement& placement, TextOutput& out) {
  if (placement.isIdentity()) {
    return;
  }
  (out << ",\"translation\":[").vector(placement.position, ',') << "],\"rotation\":[0,";
  out.single(core::sin(0.5 * placement.turnRadians)) << ",0,";
  out.single(core::cos(0.5 * placement.turnRadians)) << "],\"scale\":[";
  out.vector({placement.scale, placement.scale, placement.scale}, ',') << ']';
}

// accessors of instances follow those of the pieces
void GlbWriter::writeInstanceNode(std::size_t index, TextOutput& out) const {
  const std::size_t first = plan_.pieceAccessorCount + 3 * index;
  out << "{\"name\":\"" << plan_.files[plan_.instances[index].mesh].name << "\",\"mesh\":";
  out.integer(static_cast<long long>(plan_.instances[index].mesh))
      << ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":";
  out.integer(static_cast<long long>(first)) << ",\"ROTATION\":";
  out.integer(static_cast<long long>(first + 1)) << ",\"SCALE\":";
  out.integer(static_cast<long long>(first + 2)) << "}}}}";
}

void GlbWriter::writeNodes(TextOutput& out) const {
  out << "\"nodes\":[";
  for (std::size_t p = 0; p < plan_.plants.size(); ++p) {
    const PlantNode& plant = plan_.plants[p];
    out << (p == 0 ? "" : ",") << "{\"name\":\"plant_";
    out.integer(plant.plant) << '"';
    writePlacement(*plant.placement, out);
    if (plant.ownMesh) {
      (out << ",\"mesh\":").integer(static_cast<long long>(*plant.ownMesh)) << '}';
      continue;
    }
    out << ",\"children\":[";
    const std::size_t children = plant.meshes.size() + plant.instances.size();
    for (std::size_t k = 0; k < children; ++k) {
      (k == 0 ? out : out << ',').integer(static_cast<long long>(plant.firstChild + k));
    }
    out << "]}";
  }
  for (std::size_t i = 0; i < plan_.sceneInstanceCount; ++i) {
    out << (i + plan_.plants.size() == 0 ? "" : ",");
    writeInstanceNode(i, out);
  }
  for (const PlantNode& plant : plan_.plants) {
    for (const std::size_t mesh : plant.meshes) {
      out << ",{\"name\":\"" << plan_.files[mesh].name << "\",\"mesh\":";
      out.integer(static_cast<long long>(mesh)) << '}';
    }
    for (const std::size_t instance : plant.instances) {
      out << ',';
      writeInstanceNode(instance, out);
    }
  }
  out << "],\n";
}

void GlbWriter::writeMeshes(TextOutput& out) const {
  out << "\"meshes\":[";
  for (std::size_t i = 0; i < plan_.files.size(); ++i) {
    const FileMesh& mesh = plan_.files[i];
    out << (i == 0 ? "" : ",") << "{\"name\":\"" << mesh.name << "\",\"primitives\":[";
    for (std::size_t k = 0; k < mesh.pieceCount; ++k) {
      const Piece& piece = plan_.pieces[mesh.firstPiece + k];
      const auto accessor = static_cast<long long>(piece.firstAccessor);
      out << (k == 0 ? "" : ",") << "{\"attributes\":{\"POSITION\":";
      out.integer(accessor) << ",\"NORMAL\":";
      out.integer(accessor + 1);
      if (piece.hasCoordinates) {
        (out << ",\"TEXCOORD_0\":").integer(accessor + 2);
      }
      (out << "},\"indices\":").integer(accessor + static_cast<long long>(piece.accessorCount()) - 1)
          << ",\"material\":";
      out.integer(static_cast<long long>(plan_.materialIndex.at(plan_.materialOf(mesh, mesh.firstPiece + k)))) << '}';
    }
    out << "]}";
  }
  out << "],\n";
}

void GlbWriter::writeMaterials(TextOutput& out) const {
  out << "\"materials\":[";
  bool isFirst = true;
  for (const auto& [number, index] : plan_.materialIndex) {
    const MeshMaterial& material = plan_.meshes.materials()[number];
    const bool isTextured = material.texture != MeshMaterial::kNoTexture;
    const MeshTexture* const texture = isTextured ? &plan_.meshes.textures()[material.texture] : nullptr;
    const bool isCovered = isTextured && texture->texture->use == files::Texture::Use::Decal;
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
      (out << ",\"baseColorTexture\":{\"index\":")
              .integer(static_cast<long long>(plan_.textureIndex.at(material.texture)))
          << '}';
    }
    out << '}';
    if (emission != Vec3{}) {
      (out << ",\"emissiveFactor\":[").vector(factor(emission.x, emission.y, emission.z), ',') << ']';
    }
    // holes are cut out, so that nothing need be sorted
    const bool hasHoles = isTextured && opacity == 1.0 && texture->hasHoles();
    out << (opacity < 1.0 ? ",\"alphaMode\":\"BLEND\"" : hasHoles ? ",\"alphaMode\":\"MASK\"" : "");
    if (material.folder) {
      const std::array<double, 3>& specular = material.folder->specular;
      out << ",\"extensions\":{\"KHR_materials_specular\":{\"specularColorFactor\":[";
      out.vector(kUsualReflection * factor(specular[0], specular[1], specular[2]), ',') << "]}}";
    }
    out << ",\"doubleSided\":true}";
  }
  out << "],\n";
}

void GlbWriter::writeTextures(TextOutput& out) const {
  if (plan_.textureIndex.empty()) {
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
    for (auto at = plan_.textureIndex.begin(); at != plan_.textureIndex.end(); ++at) {
      out << (at == plan_.textureIndex.begin() ? "{" : ",{");
      write(plan_.meshes.textures()[at->first], static_cast<long long>(at->second));
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
    const std::size_t view = 2 * plan_.pieces.size() + plan_.instances.size() + static_cast<std::size_t>(index);
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
  // the attributes and the indices of each piece
  constexpr std::array<Attribute, 3> kAttributes{{{0, "VEC3"}, {12, "VEC3"}, {24, "VEC2"}}};
  out << "\"accessors\":[";
  for (std::size_t i = 0; i < plan_.pieces.size(); ++i) {
    const Piece& piece = plan_.pieces[i];
    for (std::size_t k = 0; k + 1 < piece.accessorCount(); ++k) {
      out << (i + k == 0 ? "" : ",");
      writeAccessor(2 * i, kAttributes[k], kFloat, piece.measure.vertexCount);
      if (k == 0) {
        (out << ",\"min\":[").vector(piece.measure.bounds.low, ',') << ']';
        (out << ",\"max\":[").vector(piece.measure.bounds.high, ',') << ']';
      }
      out << '}';
    }
    out << ',';
    writeAccessor(2 * i + 1, {0, "SCALAR"}, kUnsigned, piece.measure.indexCount);
    out << '}';
  }
  // translation, rotation and scale of instances, one after the other
  for (std::size_t i = 0; i < plan_.instances.size(); ++i) {
    const std::uint64_t count = plan_.instances[i].places.size();
    constexpr std::array<std::pair<std::uint64_t, std::string_view>, 3> kTables{
        {{0, "VEC3"}, {12, "VEC4"}, {28, "VEC3"}}};
    for (const auto& [bytesBefore, type] : kTables) {
      out << ',';
      writeAccessor(2 * plan_.pieces.size() + i, {bytesBefore * count, type}, kFloat, count);
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
  for (std::size_t i = 0; i < plan_.pieces.size(); ++i) {
    const Piece& piece = plan_.pieces[i];
    const std::uint64_t vertexBytes = piece.measure.vertexCount * piece.vertexBytes();
    out << (i == 0 ? "" : ",");
    writeView(piece.offset, vertexBytes);
    (out << ",\"byteStride\":").integer(static_cast<long long>(piece.vertexBytes())) << ",\"target\":34962},";
    writeView(piece.offset + vertexBytes, piece.measure.indexCount * kGlbIndexBytes);
    out << ",\"target\":34963}";
  }
  for (const auto* blocks : {&plan_.instanceBlocks, &plan_.pictureBlocks}) {
    for (const Block& block : *blocks) {
      out << ',';
      writeView(block.offset, block.byteCount);
      out << '}';
    }
  }
  out << "],\n";
}

// where plants stand, for viewers: x, y, z and radius of each
void GlbWriter::writeGround(TextOutput& out) {
  bool isFirst = true;
  const std::vector<GroundContacts> contactsOf = ground_.get();
  for (const SceneCopy& copy : plan_.meshes.copies()) {
    for (const GroundContact& contact : contactsOf[copy.scene]) {
      out << (isFirst ? ",\"extras\":{\"ground\":[[" : ",[");
      out.vector(placedPoint(copy.placement, contact.place), ',') << ',';
      out.single(copy.placement.scale * contact.radius) << ']';
      isFirst = false;
    }
  }
  out << (isFirst ? "" : "]}");
}

std::string GlbWriter::jsonText() {
  std::string text;
  TextOutput out(text);
  out << "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Espalier\"},\n\"scene\":0,\n";
  const std::size_t rootCount = plan_.plants.size() + plan_.sceneInstanceCount;
  if (rootCount == 0) {
    out << "\"scenes\":[{\"name\":\"empty\"}]}";
    out.flush();
    return text;
  }
  const bool isInstanced = !plan_.instances.empty();
  const bool hasHighlights = std::ranges::any_of(plan_.materialIndex, [this](const auto& entry) {
    return plan_.meshes.materials()[entry.first].folder.has_value();
  });
  if (isInstanced || hasHighlights) {
    out << "\"extensionsUsed\":[" << (isInstanced ? "\"EXT_mesh_gpu_instancing\"" : "")
        << (isInstanced && hasHighlights ? "," : "") << (hasHighlights ? "\"KHR_materials_specular\"" : "") << "],\n";
  }
  if (isInstanced) {
    out << "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"],\n";
  }
  writeNodes(out);
  writeMeshes(out);
  writeMaterials(out);
  writeTextures(out);
  writeAccessors(out);
  writeBufferViews(out);
  out << "\"buffers\":[{\"byteLength\":";
  out.integer(static_cast<long long>(plan_.binaryBytes)) << "}],\n\"scenes\":[{\"nodes\":[";
  for (std::size_t p = 0; p < rootCount; ++p) {
    (p == 0 ? out : out << ',').integer(static_cast<long long>(p));
  }
  out << ']';
  writeGround(out);
  out << "}]}";
  out.flush();
  return text;
}

// --- the numbers -----------------------------------------------------------------------------------------------------

void GlbWriter::writeVertices(const Mesh& mesh, bool hasCoordinates, BinaryOutput& out) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3& p = mesh.positions[i];
    const Vec3 n = unitNormal(mesh.normals[i]);
    if (hasCoordinates) {
      const auto [u, v] = mesh.coordinates[i];
      out.singles(std::array{p.x, p.y, p.z, n.x, n.y, n.z, u, 1.0 - v});  // glTF has v downward
    } else {
      out.singles(std::array{p.x, p.y, p.z, n.x, n.y, n.z});
    }
  }
}

void GlbWriter::writeIndices(const Mesh& mesh, std::uint32_t first, BinaryOutput& out) {
  for (const auto& face : mesh.faces) {
    const std::uint32_t a = first + face[0], b = first + face[1], c = first + face[2];
    if (face[3] == Mesh::kNoVertex) {
      out.uint32s(std::array{a, b, c});
    } else {
      out.uint32s(std::array{a, b, c, a, c, first + face[3]});
    }
  }
}

std::optional<std::string> GlbWriter::writePieces() {
  BinaryOutput out(target_.sink);
  // the parts of pieces, without those of pieces that have no triangles
  std::vector<std::size_t> order;
  order.reserve(plan_.own.size());
  for (std::size_t i = 0; i < plan_.ownPieceCount; ++i) {
    for (std::size_t k = 0; k < plan_.pieces[i].partCount; ++k) {
      order.push_back(plan_.pieces[i].firstPart + k);
    }
  }
  std::size_t pieceNumber = 0;  // the piece whose vertices are being written
  std::string indices;          // of the parts of that piece so far
  MeshWork work;
  work.make = [&](std::size_t i, Mesh& mesh) -> std::optional<std::string> {
    const PartOf& part = plan_.own[order[i]];
    plan_.sceneOf(part).make(plan_.partOf(part), mesh);
    return std::nullopt;
  };
  // vertices, then indices
  work.spell = [&](std::size_t i, const Mesh& mesh, std::uint64_t, std::string& bytes) {
    BinaryOutput spelled(bytes);
    writeVertices(mesh, plan_.hasCoordinates(plan_.partOf(plan_.own[order[i]]).material), spelled);
    writeIndices(mesh, plan_.firstVertices[order[i]], spelled);
    spelled.flush();
  };
  work.use = [&](std::size_t i, const Mesh& mesh, std::string_view bytes) -> std::optional<std::string> {
    const Piece& piece = plan_.pieces[pieceNumber];
    const std::size_t vertexBytes = mesh.positions.size() * piece.vertexBytes();
    indices.reserve(piece.measure.indexCount * kGlbIndexBytes);
    out.bytes(bytes.substr(0, vertexBytes));
    indices.append(bytes.substr(vertexBytes));
    if (order[i] + 1 == piece.firstPart + piece.partCount) {
      out.bytes(indices);
      indices.clear();
      ++pieceNumber;
    }
    report(plan_.own.size() + order[i] + 1);
    return std::nullopt;
  };
  if (auto problem = forMeshes(plan_.meshes.team(), order.size(), work)) {
    return problem;
  }
  for (const auto& [scene, shape] : plan_.shapes) {
    const Mesh& mesh = plan_.meshes.scene(scene).sharedMeshes()[shape];
    writeVertices(mesh, true, out);
    writeIndices(mesh, 0, out);
  }
  writeInstances(out);
  writePictures(out);
  out.flush();
  return std::nullopt;
}

void GlbWriter::writeInstances(BinaryOutput& out) const {
  for (const InstanceNode& node : plan_.instances) {
    for (const InstanceNode::Place& place : node.places) {
      out.vector(place.position);
    }
    for (const InstanceNode::Place& place : node.places) {
      for (const double component : place.rotation) {
        out.single(component);
      }
    }
    for (const InstanceNode::Place& place : node.places) {
      out.vector(place.scale);
    }
  }
}

void GlbWriter::writePictures(BinaryOutput& out) const {
  for (const auto& [texture, index] : plan_.textureIndex) {
    std::string bytes = plan_.meshes.textures()[texture].fileBytes();
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    out.bytes(bytes);
  }
}

std::optional<std::string> GlbWriter::write() {
  if (auto problem = plan_.make([this](std::size_t done) { report(done); })) {
    return problem;
  }

  // header, text padded by blanks, numbers
  const std::string json = jsonText();
  const std::uint64_t jsonBytes = (json.size() + 3) / 4 * 4;
  const bool hasBinary = plan_.binaryBytes > 0;
  const std::uint64_t fileBytes = 12 + 8 + jsonBytes + (hasBinary ? 8 + plan_.binaryBytes : 0);
  if (fileBytes > std::numeric_limits<std::uint32_t>::max()) {
    return "it would have " + std::to_string(fileBytes / 1'000'000) +
           " MB and the format holds at most 4294 MB. Write .ply or .obj, or fewer contour sides";
  }
  BinaryOutput out(target_.sink);
  out.bytes("glTF");
  out.uint32(2);
  out.uint32(static_cast<std::uint32_t>(fileBytes));
  out.uint32(static_cast<std::uint32_t>(jsonBytes));
  out.bytes("JSON");
  out.bytes(json);
  out.bytes(std::string(jsonBytes - json.size(), ' '));
  if (hasBinary) {
    out.uint32(static_cast<std::uint32_t>(plan_.binaryBytes));
    out.bytes(std::string_view("BIN\0", 4));
  }
  out.flush();
  return writePieces();
}

}  // namespace

std::optional<std::string> exportGlb(const PlacedScenes& placed, const ExportTarget& target) {
  return GlbWriter(placed, target).write();
}

}  // namespace espalier::turtle
