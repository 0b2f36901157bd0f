#include "engine/turtle/export/mesh/placed_meshes.h"

#include <algorithm>

#include "engine/core/check.h"
#include "engine/core/elementary.h"
#include "engine/turtle/export/mesh/mesh_check.h"
#include "engine/turtle/export/mesh/mesh_work.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

std::uint32_t plantCountOf(const SceneMeshes& scene) {
  // parts are sorted by plant
  return scene.parts().empty() ? 1 : scene.parts().back().plant + 1;
}

}  // namespace

Vec3 placedDirection(const ScenePlacement& placement, const Vec3& v) {
  if (placement.turnRadians == 0.0) {
    return v;
  }
  const double c = core::cos(placement.turnRadians);
  const double s = core::sin(placement.turnRadians);
  return {c * v.x + s * v.z, v.y, c * v.z - s * v.x};
}

Vec3 placedPoint(const ScenePlacement& placement, const Vec3& point) {
  return placement.position + placement.scale * placedDirection(placement, point);
}

core::Frame placedFrame(const ScenePlacement& placement, const core::Frame& frame) {
  return {.heading = placedDirection(placement, frame.heading),
          .left = placedDirection(placement, frame.left),
          .up = placedDirection(placement, frame.up)};
}

void place(Mesh& mesh, const ScenePlacement& placement) {
  if (placement.isIdentity()) {
    return;
  }
  const double c = core::cos(placement.turnRadians);
  const double s = core::sin(placement.turnRadians);
  const auto turned = [c, s](const Vec3& v) { return Vec3{c * v.x + s * v.z, v.y, c * v.z - s * v.x}; };
  for (Vec3& position : mesh.positions) {
    position = placement.position + placement.scale * turned(position);
  }
  for (Vec3& normal : mesh.normals) {
    normal = turned(normal);
  }
}

PlacedMeshes::PlacedMeshes(const PlacedScenes& placed)
    : team_(placed.scenes.empty() ? 1 : std::max(1U, placed.scenes[0].threads)) {
  for (const ExportInput& input : placed.scenes) {
    scenes_.emplace_back(input, table_, team_);
  }
  std::uint32_t plants = 0;
  firstParts_.push_back(0);
  for (const ScenePlacement& placement : placed.placements) {
    ESPALIER_CHECK(placement.scene < scenes_.size() && placement.scale > 0.0);
    copies_.push_back({placement.scene, plants, placement});
    plants += plantCountOf(scenes_[placement.scene]);
    firstParts_.push_back(firstParts_.back() + scenes_[placement.scene].parts().size());
  }
}

PlacedMeshes::Item PlacedMeshes::item(std::size_t index) const {
  // the last copy that begins at or before it; copies without parts begin where the next one does
  const auto after = std::upper_bound(firstParts_.begin(), firstParts_.end(), index);
  const auto copy = static_cast<std::size_t>(after - firstParts_.begin()) - 1;
  const SceneMeshes& scene = scenes_[copies_[copy].scene];
  return {copies_[copy], scene, scene.parts()[index - firstParts_[copy]]};
}

std::optional<std::string> PlacedMeshes::forEach(const Use& use) {
  return forEachSpelled({.use = [&](const Item& it, const Mesh& mesh, std::string_view) { return use(it, mesh); }});
}

std::optional<std::string> PlacedMeshes::forEachSpelled(const Spelling& spelling) {
  MeshWork work;
  work.make = [this](std::size_t i, Mesh& mesh) {
    const Item it = item(i);
    it.scene.make(it.part, mesh);
    place(mesh, it.copy.placement);
    return problemOf(mesh, it.scene, it.part);
  };
  if (spelling.number) {
    work.number = [&](std::size_t i, const Mesh& mesh) { return spelling.number(item(i), mesh); };
  }
  if (spelling.spell) {
    work.spell = [&](std::size_t i, const Mesh& mesh, std::uint64_t number, std::string& bytes) {
      spelling.spell(item(i), mesh, number, bytes);
    };
  }
  work.use = [&](std::size_t i, const Mesh& mesh, std::string_view bytes) {
    return spelling.use(item(i), mesh, bytes);
  };
  return forMeshes(team_, partCount(), work);
}

}  // namespace espalier::turtle
