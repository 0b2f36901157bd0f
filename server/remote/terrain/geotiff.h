#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace espalier::server {

/// Most heights of one file: each is a corner of two triangles and a number in a configuration.
inline constexpr std::size_t kMostHeights = 1'000'000;

/// Heights of a ground at the corners of equal rectangles.
struct Terrain {
  std::size_t columns = 0;                 // from west to east, at least 2
  std::size_t rows = 0;                    // from north to south, at least 2
  std::vector<double> heights;             // (rows, columns)
  double west = 0.0, north = 0.0;          // place of the first height, in the projection of the file
  double eastStep = 0.0, southStep = 0.0;  // above 0
  std::string lengthUnit;                  // "m" where the file says so; empty: it does not say

  [[nodiscard]] double east() const { return west + eastStep * static_cast<double>(columns - 1); }
  [[nodiscard]] double south() const { return north - southStep * static_cast<double>(rows - 1); }
};

/// Reads the heights of a GeoTIFF (OGC 19-008r4): one band of whole or real numbers, in strips or tiles, in any
/// compression of libtiff, north up. Coordinates in degrees, lengths or heights in feet, cells without a height (by
/// GDAL's no-data value, by a mask in the file, or never written), and more than kMostHeights are refused. The error is
/// a sentence about the file without its subject. The libraries libgeotiff and libtiff are loaded when this is first
/// called, because the program starts twice as fast without them; where they are missing the error says so. Time and
/// memory are O(heights + bytes).
[[nodiscard]] tl::expected<Terrain, std::string> readGeoTiff(std::string_view bytes);

}  // namespace espalier::server
