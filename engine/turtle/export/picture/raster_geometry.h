#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "engine/files/view_settings.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/line_look.h"
#include "engine/turtle/export/mesh/cylinder_mesh.h"
#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/mesh/tubes.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/raster_camera.h"
#include "engine/turtle/export/picture/raster_pen.h"
#include "engine/turtle/export/picture/raster_shading.h"
#include "engine/turtle/export/picture/raster_target.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// The parts of a scene as triangles on a page, one part at a time so that no second copy of the scene is made. Parts
/// are numbered: cylinders, surfaces, patches, polygons, tubes, lines, balls, labels; of equally near parts the later
/// ones are seen. A tube is a chain of lines that wears a texture, in the cylinder style.
class RasterGeometry {
 public:
  /// All must outlive the object.
  RasterGeometry(const Scene& scene, const files::ViewSettings& view, const Palette& palette, core::WorkerTeam& team);

  [[nodiscard]] std::size_t partCount() const;
  /// Adds the extent of a part in the picture plane, for one copy of the scene. Lines of the pixel style count
  /// without their width.
  void include(std::size_t part, const ScenePlacement& placement, const Projection& projection,
               PictureBounds& bounds) const;
  /// Whether all of a part is in front of the viewer.
  [[nodiscard]] bool isVisible(std::size_t part, const ScenePlacement& placement, const Projection& projection) const;
  /// Appends the triangles of a part; `organ` numbers it among the parts of all copies.
  void append(std::size_t part, const ScenePlacement& placement, const RasterCamera& camera,
              const RasterShading& shading, std::uint32_t organ, std::vector<RasterTriangle>& triangles) const;

  /// A part that is drawn in pieces, the runs of a long generalized cylinder, which is sampled once for all of them;
  /// null: it is drawn as a whole. O(points).
  [[nodiscard]] std::shared_ptr<const SweptCylinder> longCylinder(std::size_t part) const;
  /// The same as append() for one run of a long cylinder that is visible.
  void appendRun(std::size_t part, const SweptCylinder& cylinder, const CylinderRun& run,
                 const ScenePlacement& placement, const RasterCamera& camera, const RasterShading& shading,
                 std::uint32_t organ, std::vector<RasterTriangle>& triangles) const;
  /// About how many triangles append() makes of a part.
  [[nodiscard]] std::size_t triangleCountOf(std::size_t part) const;

 private:
  /// A part's place in its vector of the scene.
  enum class Kind : std::uint8_t { Cylinder, Surface, Patch, Polygon, Tube, Segment, Ball, Label };
  static constexpr std::size_t kKindCount = 8;
  struct Part {
    Kind kind;
    std::size_t index;
  };
  /// The look of a mesh of a part.
  struct Wear {
    std::int32_t colour = 0;
    std::int32_t texture = 0;
  };
  [[nodiscard]] Part partAt(std::size_t part) const;
  /// The shapes of a part that are meshes, where a copy stands.
  void forMeshes(const Part& part, const ScenePlacement& placement,
                 const std::function<void(const Mesh&, const Wear&)>& use) const;
  void appendSegment(std::uint32_t index, const ScenePlacement& placement, RasterPen& pen) const;
  void appendRoundLine(std::uint32_t index, LineEnd start, const LineEnd& end, RasterPen& pen) const;
  [[nodiscard]] const Mesh& localSurface(const SurfaceInstance& instance) const;
  [[nodiscard]] bool joins(std::uint32_t segment) const;
  [[nodiscard]] bool isPartOfTube(const Segment& segment) const { return hasTubes_ && segment.texture > 0; }

  const Scene& scene_;
  const files::ViewSettings& view_;
  const Palette& palette_;
  LineLook look_;
  std::vector<std::uint32_t> continuation_;  // the segment that goes on with a tube (segmentCount); kNoParent: none
  bool hasTubes_ = false;
  SegmentChains chains_;                              // when there are tubes
  TubeCircle tubeCircle_;                             // the same
  std::vector<std::uint32_t> tubes_;                  // first segments of the chains that wear a texture
  std::array<std::size_t, kKindCount> firstParts_{};  // number of the first part of each kind
  // surfaces, triangle surfaces, then surfaces again with texture coordinates over the whole of each
  std::vector<Mesh> surfaces_;
};

}  // namespace espalier::turtle
