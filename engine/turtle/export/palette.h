#pragma once

#include <cstdint>

#include "engine/turtle/export/exporters.h"
#include "engine/turtle/scene.h"

namespace espalier::turtle {

/// The colours of one picture. A scene whose lines all have the turtle's default colour 128 says nothing about colour: its
/// branches then go from brown to green with their order, its surfaces and polygons are leaf green.
class Palette {
 public:
  explicit Palette(const Scene& scene);

  [[nodiscard]] Colour ofSegment(const Segment& segment) const;
  [[nodiscard]] Colour ofIndex(std::int32_t index) const { return defaultColour(index); }
  /// A number that is equal for segments of equal colour, for naming materials: the colour index, or 256 + order.
  [[nodiscard]] std::int32_t materialOf(const Segment& segment) const;
  [[nodiscard]] Colour ofMaterial(std::int32_t material) const;

 private:
  bool isPlain_ = false;
  std::uint32_t maximumOrder_ = 0;
};

/// a + t (b - a), t in [0, 1].
[[nodiscard]] Colour mixed(const Colour& a, const Colour& b, double t);

}  // namespace espalier::turtle
