#pragma once

#include <span>
#include <vector>

#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/ground_contact.h"
#include "engine/turtle/export/picture/picture_bounds.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_camera.h"

namespace espalier::turtle {

/// The soft dark spots on the page where plants stand, for a camera that looks from the side.
class GroundShade {
 public:
  /// Adds the contacts of a copy of a scene.
  void add(std::span<const GroundContact> contacts, const ScenePlacement& placement);
  /// Makes room for the spots in the picture plane.
  void include(const Projection& projection, PictureBounds& bounds) const;
  /// Puts them on the page. There are none when the camera looks from above or below, or is tilted.
  void place(const RasterCamera& camera);

  [[nodiscard]] bool empty() const { return spots_.empty(); }
  /// How dark the page is at each pixel of a row, 0 to 1 (width).
  void row(int y, std::span<float> shades) const;

 private:
  struct Spot {
    double x = 0.0;  // pixels
    double y = 0.0;
    double radiusX = 0.0;
    double radiusY = 0.0;
  };
  std::vector<GroundContact> contacts_;
  std::vector<Spot> spots_;
};

}  // namespace espalier::turtle
