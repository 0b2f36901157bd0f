#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace espalier::files {

/// A picture, row by row from the top: red, green, blue and opacity of each pixel (opacity 255: nothing shows through).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  // (height, width, 4)

  /// Channel 0 is red, 1 green, 2 blue, 3 opacity; row 0 is the highest.
  [[nodiscard]] std::uint8_t at(int x, int row, int channel) const {
    return pixels[(static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 4 +
                  static_cast<std::size_t>(channel)];
  }
  bool operator==(const Image&) const = default;
};

/// Most pixels of a picture, so that a short file cannot ask for unlimited memory.
inline constexpr std::size_t kMostImagePixels = std::size_t{1} << 26;

/// How a reader treats the opacity of a file.
enum class Opacity : std::uint8_t {
  Kept,      // as in the file
  OverBlack  // the result is opaque: PNG is laid over black, other formats lose their opacity channel
};

/// Reads a PNG, JPEG, SGI (.rgb, .rgba, .bw, .sgi), Utah (.rle), PNM (P2, P3, P5, P6) or TGA picture. The first bytes
/// tell the format; a TGA file has no such bytes and is known by its name. The error is a sentence about the file.
/// O(pixels).
[[nodiscard]] tl::expected<Image, std::string> readImageFile(std::string_view name, std::string_view bytes,
                                                             Opacity opacity = Opacity::Kept);

/// The same for one format.
[[nodiscard]] tl::expected<Image, std::string> readPngImage(std::string_view bytes, Opacity opacity = Opacity::Kept);
[[nodiscard]] tl::expected<Image, std::string> readJpegImage(std::string_view bytes);
[[nodiscard]] tl::expected<Image, std::string> readSgiImage(std::string_view bytes);
[[nodiscard]] tl::expected<Image, std::string> readUtahImage(std::string_view bytes);
[[nodiscard]] tl::expected<Image, std::string> readPnmImage(std::string_view bytes);
[[nodiscard]] tl::expected<Image, std::string> readTgaImage(std::string_view bytes);

/// Whether the first bytes of a file are those of PNG or JPEG, the two formats that glTF embeds unchanged.
[[nodiscard]] bool isPng(std::string_view bytes);
[[nodiscard]] bool isJpeg(std::string_view bytes);
/// Whether they are those of the Utah Raster Toolkit.
[[nodiscard]] bool isUtah(std::string_view bytes);

/// An opaque white picture of this size; an error when it has no pixels or more than kMostImagePixels.
[[nodiscard]] tl::expected<Image, std::string> blankImage(std::uint64_t width, std::uint64_t height);

}  // namespace espalier::files
