#include "engine/turtle/export/mesh/scene_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "engine/core/check.h"
#include "engine/turtle/export/mesh/polygon_mesh.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::size_t kSweptCylinders = 8;  // that are kept
constexpr int kLeastSphereSides = 12;
constexpr int kFewestSphereSides = 8;           // of one among many
constexpr double kSphereTriangles = 250'000.0;  // of all spheres of a scene, about

/// The frame in which a local x, y, z is a world x, y, z.
constexpr core::Frame kWorldFrame{.heading = {0.0, 1.0, 0.0}, .left = {1.0, 0.0, 0.0}, .up = {0.0, 0.0, 1.0}};

}  // namespace

std::string_view organName(OrganKind kind) {
  constexpr std::array<std::string_view, 6> kNames{"branches", "cylinders", "polygons", "surfaces", "patches", "balls"};
  return kNames[static_cast<std::size_t>(kind)];
}

MaterialUse materialUseOf(OrganKind kind) {
  switch (kind) {
    case OrganKind::Branch:
    case OrganKind::Cylinder:
      return MaterialUse::Bark;
    case OrganKind::Ball:
      return MaterialUse::Fruit;
    case OrganKind::Polygon:
    case OrganKind::Surface:
    case OrganKind::Patch:
      break;
  }
  return MaterialUse::Leaf;
}

SceneMeshes::SceneMeshes(const ExportInput& input, MaterialTable& materials, core::WorkerTeam& team,
                         bool keepsDegenerate)
    : input_(input),
      scene_(input.scene),
      view_(input.view),
      palette_(input.scene, input.view, input.palette),
      look_(meshLineLookOf(input.scene, input.view)),
      chains_(chainsOf(input.scene, palette_, look_, team)),
      detail_(input.detail),
      sides_(atDetail(std::clamp(input.view.contourSides, 3, 64), input.detail, 3)),
      circle_(tubeCircle(sides_)),
      keepsDegenerate_(keepsDegenerate) {
  collectParts(materials);
  hasPlainFaces_ = std::make_unique<std::atomic<bool>[]>(parts_.size());
  makeSharedMeshes();
}

const files::Texture* SceneMeshes::textureOf(std::int32_t texture) const {
  return texture > 0 ? &view_.textures[static_cast<std::size_t>(texture) - 1] : nullptr;
}

void SceneMeshes::collectParts(MaterialTable& materials) {
  // numbers first: materials are listed by colour and texture, whatever was drawn first
  using Look = std::tuple<std::int32_t, std::int32_t, MaterialUse>;
  std::map<Look, std::uint32_t> indexOf;
  auto last = indexOf.end();  // mostly the next part looks the same
  const auto add = [&](OrganKind kind, std::size_t index, std::pair<std::int32_t, std::int32_t> worn,
                       std::uint32_t plant, std::size_t run = 0) {
    const Look look{worn.first, worn.second, materialUseOf(kind)};
    if (last == indexOf.end() || last->first != look) {
      last = indexOf.try_emplace(look, static_cast<std::uint32_t>(indexOf.size())).first;
    }
    parts_.push_back(
        {kind, static_cast<std::uint32_t>(index), last->second, plant, static_cast<std::uint32_t>(run), worn.first});
  };
  parts_.reserve(chains_.heads.size() + scene_.cylinders.size() + scene_.polygons.size() + scene_.surfaces.size() +
                 scene_.patches.size() + scene_.balls.size());
  for (const std::uint32_t head : chains_.heads) {
    const Segment& segment = scene_.segments[head];
    add(OrganKind::Branch, head, {palette_.materialOf(segment), segment.texture}, segment.plant);
  }
  for (std::size_t i = 0; i < scene_.cylinders.size(); ++i) {
    const GeneralizedCylinder& cylinder = scene_.cylinders[i];
    const std::vector<CylinderRun> runs = runsOf(cylinder);
    for (std::size_t run = 0; run < runs.size(); ++run) {
      add(OrganKind::Cylinder, i, {palette_.numberOf(runs[run].colour), cylinder.texture}, cylinder.plant, run);
    }
  }
  const auto addAll = [&](OrganKind kind, const auto& organs) {
    for (std::size_t i = 0; i < organs.size(); ++i) {
      std::int32_t texture = 0;
      if constexpr (requires { organs[i].texture; }) {
        texture = organs[i].texture;
      }
      add(kind, i, {palette_.numberOf(organs[i].colour), texture}, organs[i].plant);
    }
  };
  addAll(OrganKind::Polygon, scene_.polygons);
  addAll(OrganKind::Surface, scene_.surfaces);
  addAll(OrganKind::Patch, scene_.patches);
  addAll(OrganKind::Ball, scene_.balls);
  const auto order = [](const MeshPart& part) { return std::pair(part.plant, part.kind); };
  if (!std::ranges::is_sorted(parts_, {}, order)) {  // the parts of one plant are
    std::ranges::stable_sort(parts_, {}, order);
  }

  std::vector<std::uint32_t> inTable(indexOf.size());
  for (const auto& [look, index] : indexOf) {
    const auto& [colour, texture, use] = look;
    inTable[index] = materials.add(palette_, use, colour, view_, texture);
  }
  for (MeshPart& part : parts_) {
    part.material = inTable[part.material];
  }
}

void SceneMeshes::makeSharedMeshes() {
  for (const files::Surface& surface : view_.surfaces) {
    appendLocalSurface(shared_.emplace_back(), surface, detail_);
  }
  for (const files::TriangleSurface& surface : view_.triangleSurfaces) {
    appendLocalSurface(shared_.emplace_back(), surface);
  }
  int sides = std::max(sides_, atDetail(kLeastSphereSides, detail_, 3));
  if (!keepsDegenerate_ && !input_.usesInstancing && !scene_.balls.empty()) {
    // a sphere has about 4/3 sides^2 triangles
    const double most = std::sqrt(0.75 * kSphereTriangles * detail_ / static_cast<double>(scene_.balls.size()));
    sides = std::min(sides, std::max(kFewestSphereSides, static_cast<int>(most)));
  }
  appendSphere(shared_.emplace_back(), {}, 1.0, std::max(2, sides * 2 / 3), sides);
  appendDisc(shared_.emplace_back(), {.kind = Ball::Kind::Disc, .centre = {}, .frame = kWorldFrame}, sides);
  if (std::ranges::any_of(view_.textures, &files::Texture::isPerSurface)) {
    for (std::size_t i = 0; i < view_.surfaces.size(); ++i) {
      shared_.push_back(shared_[i]);
      setWholeCoordinates(shared_.back());
    }
  }
  if (!keepsDegenerate_) {
    std::ranges::for_each(shared_, dropDegenerateFaces);
  }
}

std::uint32_t SceneMeshes::sharedMeshOf(const MeshPart& part) const {
  const std::size_t surfaces = view_.surfaces.size();
  const std::size_t all = surfaces + view_.triangleSurfaces.size();
  if (part.kind == OrganKind::Surface) {
    const SurfaceInstance& instance = scene_.surfaces[part.index];
    const std::size_t index = instance.surface + (instance.isTriangleSurface ? surfaces : 0);
    ESPALIER_CHECK(index < (instance.isTriangleSurface ? all : surfaces));
    const files::Texture* const texture = textureOf(instance.texture);
    const bool isWhole = texture != nullptr && texture->isPerSurface && !instance.isTriangleSurface;
    return static_cast<std::uint32_t>(isWhole ? all + 2 + index : index);
  }
  if (part.kind == OrganKind::Ball) {
    const bool isSphere = scene_.balls[part.index].kind == Ball::Kind::Sphere;
    return static_cast<std::uint32_t>(isSphere ? all : all + 1);
  }
  return kNotShared;
}

std::string SceneMeshes::sharedMeshName(std::uint32_t index) const {
  const std::size_t surfaces = view_.surfaces.size();
  const std::size_t all = surfaces + view_.triangleSurfaces.size();
  if (index >= all + 2) {
    return sharedMeshName(index - static_cast<std::uint32_t>(all + 2)) + " whole";
  }
  if (index >= all) {
    return index == all ? "sphere" : "disc";
  }
  const char id = index < surfaces ? view_.surfaces[index].id : view_.triangleSurfaces[index - surfaces].id;
  // any character may name a surface; files need letters
  const bool isPlain = (id >= '0' && id <= '9') || (id >= 'A' && id <= 'Z') || (id >= 'a' && id <= 'z');
  return isPlain ? std::string("surface ") + id : "surface " + std::to_string(static_cast<unsigned char>(id));
}

OrganPlacement SceneMeshes::placementOf(const MeshPart& part) const {
  if (part.kind == OrganKind::Surface) {
    const SurfaceInstance& instance = scene_.surfaces[part.index];
    return {instance.position, instance.frame, instance.scale};
  }
  const Ball& ball = scene_.balls[part.index];
  // a sphere looks the same in every frame
  return {ball.centre,
          ball.kind == Ball::Kind::Sphere ? kWorldFrame : ball.frame,
          {ball.diameter, ball.diameter, ball.diameter}};
}

std::shared_ptr<const SweptCylinder> SceneMeshes::sweptCylinder(std::uint32_t index) const {
  {
    const std::lock_guard lock(sweptMutex_);
    const auto found = std::ranges::find(swept_, index, &SweptEntry::first);
    if (found != swept_.end()) {
      return found->second;
    }
  }
  auto swept = std::make_shared<const SweptCylinder>(scene_.cylinders[index], view_, detail_);
  const std::lock_guard lock(sweptMutex_);
  swept_.emplace_back(index, swept);
  if (swept_.size() > kSweptCylinders) {
    swept_.pop_front();
  }
  return swept;
}

void SceneMeshes::make(const MeshPart& part, Mesh& mesh) const {
  mesh.clear();
  fill(part, mesh);
  std::atomic<bool>& hasPlainFaces = hasPlainFaces_[static_cast<std::size_t>(&part - parts_.data())];
  if (!keepsDegenerate_ && !hasPlainFaces.load(std::memory_order_relaxed)) {
    hasPlainFaces.store(!dropDegenerateFaces(mesh), std::memory_order_relaxed);
  }
}

void SceneMeshes::fill(const MeshPart& part, Mesh& mesh) const {
  switch (part.kind) {
    case OrganKind::Branch: {
      const files::Texture* const texture = textureOf(scene_.segments[part.index].texture);
      appendTube(mesh, tubeOf(scene_, palette_, chains_, part.index, look_), circle_,
                 texture != nullptr ? texture->ratio : 0.0);
      return;
    }
    case OrganKind::Cylinder: {
      const std::shared_ptr<const SweptCylinder> swept = sweptCylinder(part.index);
      swept->appendRun(mesh, swept->runs()[part.run]);
      return;
    }
    case OrganKind::Polygon:
      appendPolygon(mesh, scene_.polygons[part.index].vertices);
      return;
    case OrganKind::Patch: {
      const Patch& patch = scene_.patches[part.index];
      appendPatch(mesh, patch.points, atDetail(patch.subdivisionS, detail_, 1),
                  atDetail(patch.subdivisionT, detail_, 1));
      return;
    }
    case OrganKind::Surface:
    case OrganKind::Ball:
      appendPlaced(mesh, shared_[sharedMeshOf(part)], placementOf(part));
      return;
  }
}

Provenance SceneMeshes::provenanceOfSegment(std::uint32_t segment) const {
  const Segment& of = scene_.segments[segment];
  return {of.plant, of.module, of.branchOrder};
}

Provenance SceneMeshes::provenanceOf(const MeshPart& part, const Mesh& mesh, std::size_t vertex) const {
  return mesh.vertexSegments.empty() ? provenanceOf(part) : provenanceOfSegment(mesh.vertexSegments[vertex]);
}

Provenance SceneMeshes::provenanceOf(const MeshPart& part) const {
  const auto of = [](const auto& organ) { return Provenance{organ.plant, organ.module, organ.branchOrder}; };
  switch (part.kind) {
    case OrganKind::Branch:
      return provenanceOfSegment(part.index);
    case OrganKind::Cylinder:
      return of(scene_.cylinders[part.index]);
    case OrganKind::Polygon:
      return of(scene_.polygons[part.index]);
    case OrganKind::Patch:
      return of(scene_.patches[part.index]);
    case OrganKind::Surface:
      return of(scene_.surfaces[part.index]);
    case OrganKind::Ball:
      return of(scene_.balls[part.index]);
  }
  return {};
}

}  // namespace espalier::turtle
