#pragma once

#include <cstdint>
#include <vector>

#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/picture.h"

namespace espalier::turtle {

/// A picture in few colours.
struct IndexedPicture {
  std::vector<Colour> colours;        // at most 256
  std::vector<std::uint8_t> indices;  // of each point (height, width)
};

/// Chooses at most `maximumColours` (2 to 256) colours for a picture, of which the opacity is not looked at, and gives
/// each point the nearest: boxes of colours are halved at their mean, the one with the largest squared error first
/// (Wu 1991 without his tables). A picture of fewer colours keeps them exactly. O(colours · maximumColours).
[[nodiscard]] IndexedPicture indexedPicture(const PictureImage& image, int maximumColours);

}  // namespace espalier::turtle
