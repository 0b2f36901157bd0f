#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/language/view_settings.h"
#include "engine/turtle/export/mesh.h"
#include "engine/turtle/export/raster_camera.h"
#include "engine/turtle/export/raster_shading.h"
#include "engine/turtle/export/raster_target.h"
#include "engine/turtle/scene.h"

namespace espalier::turtle {

/// The parts of a scene as triangles on a page, one part at a time so that no second copy of the scene is made. Parts
/// are numbered: cylinders, surfaces, patches, polygons, lines, balls, labels; of what is equally near the later ones
/// are seen.
class RasterGeometry {
 public:
  /// Both must outlive the object.
  RasterGeometry(const Scene& scene, const language::ViewSettings& view);

  [[nodiscard]] std::size_t partCount() const;
  /// Adds what a part covers in the picture plane. Lines of the pixel style count without their width.
  void include(std::size_t part, const Projection& projection, PictureBounds& bounds) const;
  /// Whether all of a part is in front of the viewer.
  [[nodiscard]] bool isVisible(std::size_t part, const Projection& projection) const;
  /// Appends the triangles of a part.
  void append(std::size_t part, const RasterCamera& camera, const RasterShading& shading,
              std::vector<RasterTriangle>& triangles) const;

 private:
  /// A part's place in its vector of the scene.
  enum class Kind : std::uint8_t { Cylinder, Surface, Patch, Polygon, Segment, Ball, Label };
  struct Part {
    Kind kind;
    std::size_t index;
  };
  [[nodiscard]] Part partAt(std::size_t part) const;
  [[nodiscard]] Mesh meshOf(const Part& part, std::int32_t& colour) const;
  [[nodiscard]] bool joins(std::uint32_t segment) const;

  const Scene& scene_;
  const language::ViewSettings& view_;
  std::vector<std::uint32_t> continuation_;  // the segment that goes on with a tube (segmentCount); kNoParent: none
};

}  // namespace espalier::turtle
