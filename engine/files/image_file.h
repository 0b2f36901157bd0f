#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace espalier::language {

/// A picture of points, row by row from the top: red, green, blue, opacity (255: nothing shows through).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;  // (height, width, 4)

  bool operator==(const Image&) const = default;
};

/// Largest width and height of a picture that is read.
inline constexpr int kMostImageSide = 16'384;
/// Most points of a picture that is read, so that a short file cannot ask for memory without end.
inline constexpr std::size_t kMostImagePixels = 64'000'000;

/// Reads a picture, PNG, JPEG, SGI (.rgb, .rgba, .bw, .sgi) or TGA: the kind is found by its first bytes, TGA, which
/// has none of its own, by the name. Anything wrong gives a sentence that says what.
[[nodiscard]] std::variant<Image, std::string> readImageFile(std::string_view name, std::string_view bytes);

/// The same for one format.
[[nodiscard]] std::variant<Image, std::string> readPngImage(std::string_view bytes);
[[nodiscard]] std::variant<Image, std::string> readJpegImage(std::string_view bytes);
[[nodiscard]] std::variant<Image, std::string> readSgiImage(std::string_view bytes);
[[nodiscard]] std::variant<Image, std::string> readTgaImage(std::string_view bytes);

/// Whether a file's first bytes say PNG or JPEG, the kinds that glTF embeds as they are.
[[nodiscard]] bool isPng(std::string_view bytes);
[[nodiscard]] bool isJpeg(std::string_view bytes);

/// Why a picture of this size is not read, or an empty text.
[[nodiscard]] std::string problemOfImageSize(std::uint64_t width, std::uint64_t height);

}  // namespace espalier::language
