#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/buffer.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/raster_texture.h"

namespace espalier::turtle {

/// A corner of a triangle on the page.
struct RasterVertex {
  float x = 0.0F;                 // pixels from the left edge
  float y = 0.0F;                 // pixels from the upper edge
  float nearness = 0.0F;          // larger is nearer to the viewer; linear over a triangle on the page
  std::array<float, 3> colour{};  // red, green, blue, 0 to 255
  // of a texture: u and v times `share`, which is linear on the page (1, or in a perspective one by the depth)
  float u = 0.0F;
  float v = 0.0F;
  float share = 1.0F;
};

/// A triangle on the page, either side up.
struct RasterTriangle {
  std::array<RasterVertex, 3> corners;
  float opacity = 1.0F;
  const RasterTexture* texture = nullptr;  // whose colours multiply those of the corners, and which may have holes
  std::uint32_t organ = 0;  // equal for triangles of one organ: they hide the same samples of what is behind them
};

/// The samples of some rows of a picture, 4 by 4 to a pixel, with colour and depth: what is nearer hides what is
/// farther, of equally near the later wins. Opacity below 1 covers only a part of a pixel's samples, chosen by organ
/// and place, so that the order of drawing does not matter (screen-door transparency; Mulder et al. 1998).
class RasterTarget {
 public:
  static constexpr int kSamplesAcross = 4;
  static constexpr int kTilePixels = 64;
  static constexpr int kTileSamples = kTilePixels * kSamplesAcross;  // in a row or column of a tile

  /// The page's rows `firstRow` to `firstRow + rows - 1`.
  RasterTarget(int width, int firstRow, int rows);

  /// Bytes of memory for one pixel.
  static constexpr std::size_t kBytesPerPixel = kSamplesAcross * kSamplesAcross * (sizeof(float) + 4);

  [[nodiscard]] int tileColumns() const { return (width_ + kTilePixels - 1) / kTilePixels; }
  [[nodiscard]] int tileRows() const { return (rows_ + kTilePixels - 1) / kTilePixels; }
  /// The tiles that a triangle's surrounding rectangle meets, as columns [0], [1] and rows [2], [3], ends included;
  /// nothing to draw when [0] > [1], as for a triangle so small that it lies between the samples.
  [[nodiscard]] std::array<int, 4> tilesOf(const RasterTriangle& triangle) const;

  /// Draws the part of a triangle that lies in one tile. Different tiles may be drawn at the same time.
  void draw(const RasterTriangle& triangle, int tileColumn, int tileRow);

  /// The mean colour of the samples of each pixel of one row of these, over `background` where nothing was drawn: four
  /// bytes a pixel, red, green, blue and opacity; the background is transparent when `isTransparent`. `shades` is how
  /// dark the background is at each pixel, 0 to 1; empty: nowhere.
  void resolve(int row, const Colour& background, bool isTransparent, std::span<std::uint8_t> pixels,
               std::span<const float> shades = {}) const;

 private:
  [[nodiscard]] std::size_t tileNumber(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(tileColumns()) + static_cast<std::size_t>(column);
  }
  /// The rows of samples in the tiles of a row.
  [[nodiscard]] int sampleRows(int tileRow) const {
    const int rest = rows_ - tileRow * kTilePixels;
    return (rest < kTilePixels ? rest : kTilePixels) * kSamplesAcross;
  }
  /// Where the samples of a tile begin, row by row, kTileSamples in each.
  [[nodiscard]] std::size_t firstSample(int column, int row) const {
    return (static_cast<std::size_t>(row) * static_cast<std::size_t>(tileColumns()) * kTileSamples +
            static_cast<std::size_t>(column) * static_cast<std::size_t>(sampleRows(row))) *
           kTileSamples;
  }

  int width_;
  int firstRow_;
  int rows_;
  std::vector<std::uint8_t> isDrawn_;    // by tile; the samples of others have no values
  core::Buffer<float> nearness_;         // by tile
  core::Buffer<std::uint32_t> colours_;  // the same; red in the lowest byte, 255 in the highest where drawn
};

}  // namespace espalier::turtle
