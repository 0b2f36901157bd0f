#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/frame.h"
#include "engine/core/worker_team.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/mesh/cylinder_mesh.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/mesh/mesh_material.h"
#include "engine/turtle/export/mesh/tubes.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// The kind of a part of a scene, in the order in which a plant's parts are written.
enum class OrganKind : std::uint8_t { Branch, Cylinder, Polygon, Surface, Patch, Ball };

/// Which material organs of a kind wear.
[[nodiscard]] MaterialUse materialUseOf(OrganKind kind);

/// `branches`, `cylinders`, `polygons`, `surfaces`, `patches`, `balls`.
[[nodiscard]] std::string_view organName(OrganKind kind);

/// One mesh of a scene: a tube along a chain of lines, the stretches of one colour of a generalized cylinder, or one
/// organ.
struct MeshPart {
  OrganKind kind = OrganKind::Branch;
  std::uint32_t index = 0;     // of a branch the chain's first segment, else into the scene's array of that kind
  std::uint32_t material = 0;  // index into MaterialTable::materials
  std::uint32_t plant = 0;
  std::uint32_t run = 0;    // of a generalized cylinder, by runsOf
  std::int32_t colour = 0;  // number of its colour: Palette::materialOf of lines, else the colour index
};

/// Which module of the model a piece of geometry comes from.
struct Provenance {
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::uint32_t branchOrder = 0;
};

/// The meshes of a scene, one at a time, for the mesh formats. Holds a few bytes a part and the
/// shared meshes of organs, never the meshes of the scene. World coordinates, right-handed; faces counter-clockwise
/// seen from where their normals point. Lines are swept to tubes whatever the view file's line style.
class SceneMeshes {
 public:
  static constexpr std::uint32_t kNotShared = 0xFFFFFFFF;

  /// `input`, what it refers to and `materials`, to which the scene's are added, must outlive the object. Triangles
  /// without area, as at the tip of a patch, are left out unless `keepsDegenerate`. `team` is used here only.
  SceneMeshes(const ExportInput& input, MaterialTable& materials, core::WorkerTeam& team, bool keepsDegenerate = false);

  /// All parts by plant, kind and order of drawing.
  [[nodiscard]] std::span<const MeshPart> parts() const { return parts_; }
  [[nodiscard]] const ExportInput& input() const { return input_; }

  /// Fills `mesh`, which is cleared first, with one of parts() in world coordinates. Thread-safe.
  void make(const MeshPart& part, Mesh& mesh) const;

  /// Meshes that several organs share: surfaces and triangle surfaces of the view file, the sphere, the disc.
  [[nodiscard]] std::span<const Mesh> sharedMeshes() const { return shared_; }
  /// The shared mesh of a part, an index into sharedMeshes(); kNotShared: the part has its own.
  [[nodiscard]] std::uint32_t sharedMeshOf(const MeshPart& part) const;
  /// `surface l`, `sphere` or `disc`.
  [[nodiscard]] std::string sharedMeshName(std::uint32_t index) const;
  /// The place of a part with a shared mesh.
  [[nodiscard]] OrganPlacement placementOf(const MeshPart& part) const;

  /// The module that drew a part. A branch has that of its first segment.
  [[nodiscard]] Provenance provenanceOf(const MeshPart& part) const;
  /// The module that drew a vertex of its mesh: a branch has one for each segment.
  [[nodiscard]] Provenance provenanceOf(const MeshPart& part, const Mesh& mesh, std::size_t vertex) const;
  [[nodiscard]] Provenance provenanceOfSegment(std::uint32_t segment) const;

 private:
  void collectParts(MaterialTable& materials);
  void makeSharedMeshes();
  void fill(const MeshPart& part, Mesh& mesh) const;
  [[nodiscard]] const files::Texture* textureOf(std::int32_t texture) const;
  [[nodiscard]] std::shared_ptr<const SweptCylinder> sweptCylinder(std::uint32_t index) const;

  const ExportInput& input_;
  const Scene& scene_;
  const files::ViewSettings& view_;
  Palette palette_;
  LineLook look_;
  SegmentChains chains_;
  std::vector<MeshPart> parts_;
  // by part: none of its faces was near to having no area, so that they need not be looked at when it is made again
  std::unique_ptr<std::atomic<bool>[]> hasPlainFaces_;
  // surfaces, triangle surfaces, sphere, disc, then surfaces again with texture coordinates over the whole of each
  std::vector<Mesh> shared_;
  double detail_ = 1.0;  // factor of the numbers of sides and subdivisions
  int sides_ = 8;        // around tubes
  TubeCircle circle_;    // of so many sides
  bool keepsDegenerate_ = false;
  // the cylinders that were asked for last, by index: the runs of one are asked for one after the other, by several
  // threads
  using SweptEntry = std::pair<std::uint32_t, std::shared_ptr<const SweptCylinder>>;
  mutable std::mutex sweptMutex_;
  mutable std::deque<SweptEntry> swept_;
};

}  // namespace espalier::turtle
