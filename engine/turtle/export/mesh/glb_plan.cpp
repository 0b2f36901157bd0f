#include "engine/turtle/export/mesh/glb_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <string_view>

#include "engine/core/elementary.h"
#include "engine/turtle/export/mesh/mesh_work.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::uint64_t kPieceVertices = 1'000'000;  // about: pieces end with a part

std::string_view nameOf(MaterialUse use) {
  constexpr std::array<std::string_view, 3> kNames{"branches", "leaves", "fruits"};
  return kNames[static_cast<std::size_t>(use)];
}

// a frame that is no rotation has no place in a node, and not all programs turn the sides of a mirrored one
bool fitsNode(const OrganPlacement& placement) {
  return placement.scale.x * placement.scale.y * placement.scale.z > 0.0 && rotationOf(placement.frame).has_value();
}

}  // namespace

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

void GlbPlan::sortParts() {
  copyCount_.assign(meshes.sceneCount(), 0);
  for (const SceneCopy& copy : meshes.copies()) {
    ++copyCount_[copy.scene];
  }
  for (std::uint32_t s = 0; s < meshes.sceneCount(); ++s) {
    const SceneMeshes& scene = meshes.scene(s);
    const std::span<const MeshPart> parts = scene.parts();
    for (std::uint32_t i = 0; copyCount_[s] > 0 && i < parts.size(); ++i) {
      // of a scene that is placed several times the whole is the shared mesh
      const bool isInstance = usesInstancing && copyCount_[s] == 1 &&
                              scene.sharedMeshOf(parts[i]) != SceneMeshes::kNotShared &&
                              fitsNode(scene.placementOf(parts[i]));
      (isInstance ? organs : own).push_back({s, i});
    }
  }
  // scenes, plants and kinds are in order
  for (std::size_t i = 0, end = 0; i < own.size(); i = end) {
    while (end < own.size() && sharesMesh(own[i], own[end])) {
      ++end;
    }
    sortByMaterial(std::span(own).subspan(i, end - i));
  }
}

// the parts of one mesh of the file; mostly there are few materials
void GlbPlan::sortByMaterial(std::span<PartOf> parts) {
  const auto material = [this](const PartOf& p) { return partOf(p).material; };
  if (std::ranges::is_sorted(parts, {}, material)) {
    return;
  }
  if (parts.size() < meshes.materials().size()) {
    std::ranges::stable_sort(parts, {}, material);
    return;
  }
  std::vector<std::size_t> places(meshes.materials().size() + 1, 0);
  for (const PartOf& part : parts) {
    ++places[material(part) + 1];
  }
  std::partial_sum(places.begin(), places.end(), places.begin());
  std::vector<PartOf> sorted(parts.size());
  for (const PartOf& part : parts) {
    sorted[places[material(part)]++] = part;
  }
  std::ranges::copy(sorted, parts.begin());
}

// whether two neighbours in the order are in one mesh of the file
bool GlbPlan::sharesMesh(const PartOf& a, const PartOf& b) const {
  return a.scene == b.scene && (isRepeated(a.scene) || (partOf(a).plant == partOf(b).plant && useOf(a) == useOf(b)));
}

std::optional<std::string> GlbPlan::measurePieces(const std::function<void(std::size_t)>& report) {
  std::vector<MeshMeasure> measures(own.size());
  firstVertices.resize(own.size());
  MeshWork work;
  work.make = [&](std::size_t i, Mesh& mesh) {
    sceneOf(own[i]).make(partOf(own[i]), mesh);
    measures[i].add(mesh);
    return problemOf(mesh, sceneOf(own[i]), partOf(own[i]));
  };
  work.use = [&](std::size_t i, const Mesh&, std::string_view) -> std::optional<std::string> {
    const MeshPart& next = partOf(own[i]);
    report(i + 1);
    const bool continuesPiece = i > 0 && sharesMesh(own[i - 1], own[i]) && partOf(own[i - 1]).material == next.material;
    if (!continuesPiece || pieces.back().measure.vertexCount >= kPieceVertices) {
      pieces.push_back({.material = next.material, .firstPart = i});
    }
    ++pieces.back().partCount;
    firstVertices[i] = static_cast<std::uint32_t>(pieces.back().measure.vertexCount);
    pieces.back().measure.add(measures[i]);
    return std::nullopt;
  };
  auto problem = forMeshes(meshes.team(), own.size(), work);
  // lines without length or polygons without three corners have no mesh
  std::erase_if(pieces, [](const Piece& piece) { return piece.measure.indexCount == 0; });
  ownPieceCount = pieces.size();
  return problem;
}

void GlbPlan::nameMeshes() {
  filesOf_.resize(meshes.sceneCount());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const PartOf& first = own[pieces[i].firstPart];
    if (i > 0 && sharesMesh(own[pieces[i - 1].firstPart], first)) {
      ++files.back().pieceCount;
      continue;
    }
    const std::string name = isRepeated(first.scene) ? "scene_" + std::to_string(first.scene)
                                                     : "plant_" + std::to_string(partOf(first).plant) + " " +
                                                           std::string(nameOf(useOf(first)));
    filesOf_[first.scene].add(files.size());
    files.push_back({name, i, 1});
  }
}

// a piece for each shape in use, a mesh for each shape and material
void GlbPlan::planOrgans() {
  std::erase_if(organs, [this](const PartOf& p) {
    return sceneOf(p).sharedMeshes()[sceneOf(p).sharedMeshOf(partOf(p))].faces.empty();
  });
  organsOf_.resize(meshes.sceneCount());
  std::map<Shape, std::size_t> pieceOf;
  for (std::size_t i = 0; i < organs.size(); ++i) {
    const PartOf& organ = organs[i];
    organsOf_[organ.scene].add(i);
    const Shape shape{organ.scene, sceneOf(organ).sharedMeshOf(partOf(organ))};
    const std::uint32_t material = partOf(organ).material;
    if (pieceOf.emplace(shape, pieces.size()).second) {
      pieces.push_back({});
      pieces.back().measure.add(sceneOf(organ).sharedMeshes()[shape.second]);
      shapes.push_back(shape);
    }
    if (organMesh.emplace(std::pair(shape, material), files.size()).second) {
      files.push_back({sceneOf(organ).sharedMeshName(shape.second) + " " + meshes.materials()[material].name,
                       pieceOf[shape], 1, material});
    }
  }
}

void GlbPlan::planNodes() {
  std::map<std::uint32_t, std::size_t> instanceOf;  // by scene
  for (const SceneCopy& copy : meshes.copies()) {
    const Range& ofScene = filesOf_[copy.scene];
    if (!isRepeated(copy.scene) || ofScene.begin == ofScene.end) {
      continue;
    }
    if (!usesInstancing) {
      plants.push_back({.plant = copy.firstPlant, .placement = &copy.placement, .ownMesh = ofScene.begin});
      continue;
    }
    if (instanceOf.emplace(copy.scene, instances.size()).second) {
      instances.push_back({ofScene.begin, {}});
    }
    const ScenePlacement& at = copy.placement;
    instances[instanceOf[copy.scene]].places.push_back(
        {at.position,
         {0.0, core::sin(0.5 * at.turnRadians), 0.0, core::cos(0.5 * at.turnRadians)},
         {at.scale, at.scale, at.scale}});
  }
  sceneInstanceCount = instances.size();
  for (const SceneCopy& copy : meshes.copies()) {
    if (!isRepeated(copy.scene)) {
      planPlants(copy);
    }
  }
  std::ranges::stable_sort(plants, {}, &PlantNode::plant);
  // plants, then instances of scenes, then the nodes below the plants
  std::size_t node = plants.size() + sceneInstanceCount;
  for (PlantNode& plant : plants) {
    plant.firstChild = node;
    node += plant.meshes.size() + plant.instances.size();
  }
}

// the plants of a scene that is placed once
void GlbPlan::planPlants(const SceneCopy& copy) {
  std::map<std::uint32_t, PlantNode> content;
  for (std::size_t i = filesOf_[copy.scene].begin; i < filesOf_[copy.scene].end; ++i) {
    content[partOf(own[pieces[files[i].firstPiece].firstPart]).plant].meshes.push_back(i);
  }
  planInstances(copy, content);
  for (auto& [number, plant] : content) {
    plant.plant = copy.firstPlant + number;
    plant.placement = &copy.placement;
    plants.push_back(std::move(plant));
  }
}

// a node for each shape and material of a plant
void GlbPlan::planInstances(const SceneCopy& copy, std::map<std::uint32_t, PlantNode>& content) {
  std::map<std::pair<std::uint32_t, std::size_t>, std::size_t> nodeOf;  // by plant and mesh
  for (std::size_t i = organsOf_[copy.scene].begin; i < organsOf_[copy.scene].end; ++i) {
    const MeshPart& part = partOf(organs[i]);
    const SceneMeshes& scene = sceneOf(organs[i]);
    const std::size_t mesh = organMesh.at({{copy.scene, scene.sharedMeshOf(part)}, part.material});
    const auto [node, isNew] = nodeOf.try_emplace({part.plant, mesh}, instances.size());
    if (isNew) {
      content[part.plant].instances.push_back(instances.size());
      instances.push_back({mesh, {}});
    }
    const OrganPlacement at = scene.placementOf(part);
    instances[node->second].places.push_back({at.position, *rotationOf(at.frame), at.scale});
  }
}

// a small file has none that nothing wears
bool GlbPlan::hasCoordinates(std::uint32_t material) const {
  return !usesInstancing || meshes.materials()[material].texture != MeshMaterial::kNoTexture;
}

std::uint32_t GlbPlan::materialOf(const FileMesh& mesh, std::size_t piece) const {
  return mesh.material.value_or(pieces[piece].material);
}

void GlbPlan::placeBlocks() {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Piece& piece = pieces[i];
    // shapes are few, and some of their materials may wear a texture
    piece.hasCoordinates = i >= ownPieceCount || hasCoordinates(piece.material);
    piece.firstAccessor = pieceAccessorCount;
    pieceAccessorCount += piece.accessorCount();
    piece.offset = binaryBytes;
    binaryBytes += piece.bytes();
  }
  for (const InstanceNode& node : instances) {
    instanceBlocks.push_back({binaryBytes, node.places.size() * kGlbInstanceBytes});
    binaryBytes += instanceBlocks.back().byteCount;
  }
  for (const FileMesh& mesh : files) {
    for (std::size_t k = 0; k < mesh.pieceCount; ++k) {
      materialIndex.emplace(materialOf(mesh, mesh.firstPiece + k), 0);
    }
  }
  std::size_t index = 0;
  for (auto& material : materialIndex) {
    material.second = index++;
    const std::uint32_t texture = meshes.materials()[material.first].texture;
    if (texture != MeshMaterial::kNoTexture) {
      textureIndex.emplace(texture, 0);
    }
  }
  index = 0;
  for (auto& [texture, number] : textureIndex) {
    number = index++;
    const std::uint64_t bytes = meshes.textures()[texture].fileBytes().size();
    pictureBlocks.push_back({binaryBytes, bytes});
    binaryBytes += (bytes + 3) / 4 * 4;
  }
}

std::optional<std::string> GlbPlan::make(const std::function<void(std::size_t)>& report) {
  sortParts();
  if (auto problem = measurePieces(report)) {
    return problem;
  }
  nameMeshes();
  planOrgans();
  planNodes();
  placeBlocks();
  return std::nullopt;
}

}  // namespace espalier::turtle
