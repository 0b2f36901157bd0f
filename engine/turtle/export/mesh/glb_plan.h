#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/placed_meshes.h"

namespace espalier::turtle {

inline constexpr std::uint64_t kGlbPlainBytes = 24;      // of a vertex: position, normal
inline constexpr std::uint64_t kGlbCoordinateBytes = 8;  // and texture coordinates
inline constexpr std::uint64_t kGlbIndexBytes = 4;
inline constexpr std::uint64_t kGlbInstanceBytes = 40;  // translation, rotation, scale

/// The amount and the extent of a mesh in a file.
struct MeshMeasure {
  std::uint64_t vertexCount = 0;
  std::uint64_t indexCount = 0;
  Bounds bounds{};

  void add(const Mesh& mesh) {
    vertexCount += mesh.positions.size();
    indexCount += 3 * mesh.triangleCount();
    bounds.add(mesh);
  }
  void add(const MeshMeasure& other) {
    vertexCount += other.vertexCount;
    indexCount += other.indexCount;
    bounds.add(other.bounds);
  }
};

/// A run of parts of one scene that becomes one primitive: vertices and indices that follow each other in the file.
struct Piece {
  std::uint32_t material = 0;
  std::size_t firstPart = 0;  // into the order of parts
  std::size_t partCount = 0;
  MeshMeasure measure{};
  std::uint64_t offset = 0;  // in the binary chunk
  std::size_t firstAccessor = 0;
  bool hasCoordinates = true;  // of a texture

  [[nodiscard]] std::uint64_t vertexBytes() const {
    return kGlbPlainBytes + (hasCoordinates ? kGlbCoordinateBytes : 0);
  }
  [[nodiscard]] std::size_t accessorCount() const { return hasCoordinates ? 4 : 3; }
  [[nodiscard]] std::uint64_t bytes() const {
    return measure.vertexCount * vertexBytes() + measure.indexCount * kGlbIndexBytes;
  }
};

/// A mesh of the file: all organs of one use (MaterialUse) of a plant, a piece for each of their materials; a shape
/// that organs share in one material; or all of a scene that is placed several times.
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

/// A plant of a copy, and the nodes below it.
struct PlantNode {
  std::uint32_t plant = 0;  // among all copies
  const ScenePlacement* placement = nullptr;
  std::optional<std::size_t> ownMesh = {};  // of a scene that is placed several times; nothing stands below then
  std::vector<std::size_t> meshes = {};     // into the file's meshes
  std::vector<std::size_t> instances = {};  // into GlbPlan::instances
  std::size_t firstChild = 0;               // node
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
  struct Place {
    core::Vec3 position;
    std::array<double, 4> rotation{};  // x, y, z, w
    core::Vec3 scale{1.0, 1.0, 1.0};
  };
  std::size_t mesh = 0;
  std::vector<Place> places;
};

/// The range of a table of the binary chunk behind the meshes: instances and pictures.
struct Block {
  std::uint64_t offset = 0;
  std::uint64_t byteCount = 0;
};

/// The contents of a .glb with their places, without the meshes. The plan is made before anything is written.
struct GlbPlan {
  using Shape = std::pair<std::uint32_t, std::uint32_t>;  // scene and shared mesh

  explicit GlbPlan(const PlacedScenes& placed) : meshes(placed), usesInstancing(placed.scenes[0].usesInstancing) {}

  /// Makes each mesh once to count it; an error sentence when one cannot be written. `report` is told how many are
  /// done.
  [[nodiscard]] std::optional<std::string> make(const std::function<void(std::size_t)>& report);

  [[nodiscard]] const SceneMeshes& sceneOf(const PartOf& part) const { return meshes.scene(part.scene); }
  [[nodiscard]] const MeshPart& partOf(const PartOf& part) const { return sceneOf(part).parts()[part.part]; }
  /// Whether the vertices of own parts of a material have texture coordinates.
  [[nodiscard]] bool hasCoordinates(std::uint32_t material) const;
  /// The material of a primitive.
  [[nodiscard]] std::uint32_t materialOf(const FileMesh& mesh, std::size_t piece) const;

  PlacedMeshes meshes;
  bool usesInstancing;
  std::vector<PartOf> own;                   // parts with vertices of their own, by scene, plant, use and material
  std::vector<std::uint32_t> firstVertices;  // of own parts: number of the first vertex in its piece
  std::vector<PartOf> organs;                // with instancing: parts that are instances of shapes, by scene and plant
  std::vector<Piece> pieces;                 // own ones, then the shared shapes in use
  std::size_t ownPieceCount = 0;
  std::vector<FileMesh> files;
  std::map<std::pair<Shape, std::uint32_t>, std::size_t> organMesh;  // by shape and material
  std::vector<Shape> shapes;                                         // of the shared pieces, in order
  std::vector<PlantNode> plants;
  std::vector<InstanceNode> instances;  // of scenes, which stand in no plant, then of organs
  std::size_t sceneInstanceCount = 0;
  std::size_t pieceAccessorCount = 0;
  std::vector<Block> instanceBlocks, pictureBlocks;
  std::map<std::uint32_t, std::size_t> materialIndex, textureIndex;  // in the file, of those of the table in use
  std::uint64_t binaryBytes = 0;

 private:
  void sortParts();
  void sortByMaterial(std::span<PartOf> parts);
  [[nodiscard]] std::optional<std::string> measurePieces(const std::function<void(std::size_t)>& report);
  void nameMeshes();
  void planOrgans();
  void planNodes();
  void planPlants(const SceneCopy& copy);
  void planInstances(const SceneCopy& copy, std::map<std::uint32_t, PlantNode>& content);
  void placeBlocks();
  [[nodiscard]] MaterialUse useOf(const PartOf& part) const { return materialUseOf(partOf(part).kind); }
  [[nodiscard]] bool isRepeated(std::uint32_t scene) const { return copyCount_[scene] > 1; }
  [[nodiscard]] bool sharesMesh(const PartOf& a, const PartOf& b) const;

  std::vector<std::uint32_t> copyCount_;   // by scene
  std::vector<Range> filesOf_, organsOf_;  // own meshes and organs by scene
};

/// x, y, z, w of the rotation that takes x, y, z to left, heading, up; nothing when these are no rotation.
[[nodiscard]] std::optional<std::array<double, 4>> rotationOf(const core::Frame& frame);

}  // namespace espalier::turtle
