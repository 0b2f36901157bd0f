#pragma once

#include <cstdint>
#include <optional>

#include "engine/files/colour_files.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// RGB of a colour index, each 0..255.
struct Colour {
  unsigned char red = 0, green = 0, blue = 0;
};

/// The colour of an index without a palette: Espalier's own readable botanical ramp.
[[nodiscard]] Colour defaultColour(std::int32_t index);

/// The colours of one picture: those of a model folder's maps or materials, else Espalier's own. There a scene whose
/// lines all have the turtle's default colour 128 says nothing about colour: its branches then go from brown to green
/// with their order, its surfaces and polygons are leaf green.
class Palette {
 public:
  /// `colours` is a model folder's and must outlive the object; null or empty: there is none.
  explicit Palette(const Scene& scene, const files::Palette* colours = nullptr);

  [[nodiscard]] Colour ofSegment(const Segment& segment) const;
  [[nodiscard]] Colour ofIndex(std::int32_t index) const;
  /// 0 to 1; below 1 only for materials of the folder.
  [[nodiscard]] double opacityOfIndex(std::int32_t index) const;
  /// The page's colour.
  [[nodiscard]] Colour background() const;
  /// The folder's material of a colour index; nothing when the folder has none.
  [[nodiscard]] std::optional<files::Material> folderMaterial(std::int32_t index) const;
  /// A number that is equal for segments of equal colour, for naming materials: the colour index, or 256 + order.
  [[nodiscard]] std::int32_t materialOf(const Segment& segment) const;
  [[nodiscard]] Colour ofMaterial(std::int32_t material) const;

 private:
  const files::Palette* colours_ = nullptr;
  bool isPlain_ = false;
  std::uint32_t maximumOrder_ = 0;
};

/// a + t (b - a), t in [0, 1].
[[nodiscard]] Colour mixed(const Colour& a, const Colour& b, double t);

}  // namespace espalier::turtle
