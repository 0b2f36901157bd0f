#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// RGB of a colour index, each 0..255.
struct Colour {
  unsigned char red = 0, green = 0, blue = 0;
};

/// The colour of an index without a palette: Espalier's own readable botanical ramp.
[[nodiscard]] Colour defaultColour(std::int32_t index);

/// All default colours, as a palette.
[[nodiscard]] files::Palette defaultPalette();

/// The colours of a model: those of its folder; else the default colours with the entries of its view file; empty:
/// neither has any.
[[nodiscard]] files::Palette paletteOf(const files::ViewSettings& view, const files::Palette& folder);

/// The colours of one picture: paletteOf, else Espalier's own. There a plant whose lines all have the turtle's default
/// colour 128 says nothing about colour: wood is brown, paler with its order, and surfaces and polygons are leaf green.
/// Branches of a plant without organs go from brown to green.
class Palette {
 public:
  /// `folder` has the colours of a model folder and must outlive the object; null or empty: there are none.
  Palette(const Scene& scene, const files::ViewSettings& view, const files::Palette* folder = nullptr);

  [[nodiscard]] Colour ofSegment(const Segment& segment) const;
  [[nodiscard]] Colour ofIndex(std::int32_t index) const;
  /// 0 to 1; below 1 only for materials of the folder.
  [[nodiscard]] double opacityOfIndex(std::int32_t index) const;
  /// The page's colour.
  [[nodiscard]] Colour background() const;
  /// The folder's material of a colour index; nothing when the folder has none.
  [[nodiscard]] std::optional<files::Material> folderMaterial(std::int32_t index) const;
  /// The number of a colour index: itself where the model has a block of colours for it, else its place among 0 to 255.
  [[nodiscard]] std::int32_t numberOf(std::int32_t index) const;
  /// A number that is equal for segments of equal colour, for naming materials: numberOf its colour, or beyond all
  /// colours one for each order.
  [[nodiscard]] std::int32_t materialOf(const Segment& segment) const;
  [[nodiscard]] Colour ofMaterial(std::int32_t material) const;

 private:
  [[nodiscard]] bool isPlain(std::uint32_t plant) const {
    return !hasOwnLines_ && (plant >= isColoured_.size() || !isColoured_[plant]);
  }

  std::shared_ptr<const files::Palette> entries_;  // with the colours of the view file; null: none
  const files::Palette* colours_ = nullptr;
  bool hasOwnLines_ = false;      // the folder or the view file has the colour of lines
  std::vector<bool> isColoured_;  // by plant: a line has another colour than the default
  bool hasOrgans_ = false;
  std::uint32_t maximumOrder_ = 0;
};

/// a + t (b - a), t in [0, 1].
[[nodiscard]] Colour mixed(const Colour& a, const Colour& b, double t);

}  // namespace espalier::turtle
