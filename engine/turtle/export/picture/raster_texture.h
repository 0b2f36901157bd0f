#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/files/view_settings.h"
#include "engine/turtle/export/palette.h"

namespace espalier::turtle {

/// The picture that a shape wears, at all sizes down to one point (Williams 1983), for smooth sampling.
class RasterTexture {
 public:
  /// A texture that multiplies the colour below it is the same for all colours; of others the colour becomes part.
  RasterTexture(const files::Texture& texture, const Colour& below);

  /// Colours of the shape are to be computed as of white: the picture holds the shape's own.
  [[nodiscard]] bool hidesColour() const { return hidesColour_; }

  /// Red, green, blue, 0 to 1, and opacity at a place, interpolated between points; u is to the right, v upward, and
  /// the picture is repeated. `level`: how often it is halved, of levelOf.
  [[nodiscard]] std::array<float, 4> at(double u, double v, std::size_t level) const;
  /// The level at which a point of the picture is about as large as a sample, of the area of a triangle in texture
  /// coordinates and in samples.
  [[nodiscard]] std::size_t levelOf(double textureArea, double sampleArea) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> pixels;  // (height, width, 4), colours multiplied by their opacity
  };
  std::vector<Level> levels_;  // full size first
  bool hidesColour_ = false;
};

}  // namespace espalier::turtle
