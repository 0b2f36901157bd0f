#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/mesh/mesh_material.h"
#include "engine/turtle/export/mesh/scene_meshes.h"

namespace espalier::turtle {

/// A copy of a scene, where it stands.
struct SceneCopy {
  std::uint32_t scene = 0;
  std::uint32_t firstPlant = 0;  // number of the copy's plant 0 among the plants of all copies
  ScenePlacement placement;
};

/// A placed point, and a placed normal or other direction, whose length stays.
[[nodiscard]] core::Vec3 placedPoint(const ScenePlacement& placement, const core::Vec3& point);
[[nodiscard]] core::Vec3 placedDirection(const ScenePlacement& placement, const core::Vec3& direction);
[[nodiscard]] core::Frame placedFrame(const ScenePlacement& placement, const core::Frame& frame);
void place(Mesh& mesh, const ScenePlacement& placement);

/// The meshes of copies of scenes, for the mesh formats. Holds no mesh but the shared ones of each
/// scene's organs.
class PlacedMeshes {
 public:
  /// Everything referred to must outlive the object.
  explicit PlacedMeshes(const PlacedScenes& placed);

  [[nodiscard]] std::span<const MeshMaterial> materials() const { return table_.materials(); }
  [[nodiscard]] std::span<const MeshTexture> textures() const { return table_.textures(); }
  [[nodiscard]] std::size_t sceneCount() const { return scenes_.size(); }
  [[nodiscard]] const SceneMeshes& scene(std::size_t index) const { return scenes_[index]; }
  [[nodiscard]] std::span<const SceneCopy> copies() const { return copies_; }
  /// The number of parts of all copies.
  [[nodiscard]] std::size_t partCount() const { return firstParts_.back(); }

  /// One part of one copy.
  struct Item {
    const SceneCopy& copy;
    const SceneMeshes& scene;
    const MeshPart& part;

    [[nodiscard]] std::uint32_t plant() const { return copy.firstPlant + part.plant; }
  };
  [[nodiscard]] Item item(std::size_t index) const;

  /// Makes the mesh of every part of every copy in world coordinates and hands it over, copy after copy, each in the
  /// order of its parts, one at a time on any thread of the team. Refuses positions that files cannot hold. Stops at
  /// the first sentence, which is returned.
  using Use = std::function<std::optional<std::string>(const Item& item, const Mesh& mesh)>;
  [[nodiscard]] std::optional<std::string> forEach(const Use& use);
  /// The same with the bytes of each mesh, which several threads spell (MeshWork).
  struct Spelling {
    std::function<std::uint64_t(const Item&, const Mesh&)> number = {};
    std::function<void(const Item&, const Mesh&, std::uint64_t number, std::string& bytes)> spell = {};
    std::function<std::optional<std::string>(const Item&, const Mesh&, std::string_view bytes)> use = {};
  };
  [[nodiscard]] std::optional<std::string> forEachSpelled(const Spelling& spelling);

  /// The threads that make meshes.
  [[nodiscard]] core::WorkerTeam& team() { return team_; }

 private:
  MaterialTable table_;
  std::deque<SceneMeshes> scenes_;  // a deque: they hold references to their inputs
  std::vector<SceneCopy> copies_;
  std::vector<std::size_t> firstParts_;  // number of each copy's first part; behind them their count (copyCount + 1)
  core::WorkerTeam team_;
};

}  // namespace espalier::turtle
