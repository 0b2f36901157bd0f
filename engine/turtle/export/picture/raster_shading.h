#pragma once

#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "engine/core/vec3.h"
#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_camera.h"
#include "engine/turtle/export/picture/raster_texture.h"

namespace espalier::turtle {

/// The material of a shape.
struct Look {
  Colour colour;
  std::optional<files::Material> material;  // of the folder
  double opacity = 1.0;
  const RasterTexture* texture = nullptr;  // null: none
  bool isThin = false;                     // a leaf or petal, through which light comes
};

/// The textures that a scene's shapes wear in a picture, each made when it is first asked for. Thread-safe.
class RasterTextures {
 public:
  /// `view` must outlive the object.
  explicit RasterTextures(const files::ViewSettings& view) : view_(view) {}
  /// A texture of the view file, from 1, over a colour; 0: null.
  [[nodiscard]] const RasterTexture* find(std::int32_t texture, const Colour& below);

 private:
  const files::ViewSettings& view_;
  std::mutex mutex_;
  std::map<std::pair<std::int32_t, int>, RasterTexture> textures_;  // by number and the colour below, -1: any
};

/// The light that a picture is seen in: the view file's lights when it has some, else Espalier's own, of which the key
/// light comes from the view file's `light direction` when it has one. Distant parts fade a little into the page.
class RasterShading {
 public:
  /// `view`, which has the lights, `projection`, `palette` and `textures` must outlive the object. `bounds` is what the
  /// picture shows.
  RasterShading(const files::ViewSettings& view, const Projection& projection, const Palette& palette,
                RasterTextures& textures, const PictureBounds& bounds, const Colour& background);

  [[nodiscard]] Look lookOfIndex(std::int32_t index, std::int32_t texture = 0) const;
  [[nodiscard]] Look lookOf(const Segment& segment) const;

  /// Faces are lit, else they have their plain colour.
  [[nodiscard]] bool isLit() const { return isLit_; }
  /// Every face has one brightness.
  [[nodiscard]] bool isFlat() const { return isFlat_; }
  [[nodiscard]] bool isWireframe() const { return isWireframe_; }

  /// The colour (0 to 255) at a point of a surface with a unit normal; the side toward the viewer counts. `depth` is
  /// the point's distance from the viewer.
  [[nodiscard]] std::array<float, 3> lit(const Look& look, const core::Vec3& point, core::Vec3 normal,
                                         double depth) const;
  /// The colour without any light.
  [[nodiscard]] std::array<float, 3> plain(const Look& look, double depth) const;

 private:
  [[nodiscard]] Look worn(Look look, std::int32_t texture) const;
  [[nodiscard]] core::Vec3 litByOwnLights(const Look& look, const core::Vec3& normal,
                                          const core::Vec3& towardViewer) const;
  [[nodiscard]] core::Vec3 litByViewLights(const Look& look, const core::Vec3& point, const core::Vec3& normal,
                                           const core::Vec3& towardViewer) const;
  [[nodiscard]] std::array<float, 3> faded(const core::Vec3& colour, double depth) const;

  const files::ViewSettings& view_;
  const Projection& projection_;
  const Palette& palette_;
  RasterTextures& textures_;
  core::Vec3 key_, fill_, sky_;  // toward the lights
  core::Vec3 background_;        // 0 to 1
  double nearest_ = 0.0;
  double fadePerUnit_ = 0.0;
  bool isLit_ = true;
  bool isFlat_ = false;
  bool isWireframe_ = false;
};

}  // namespace espalier::turtle
