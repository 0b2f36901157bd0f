#include "engine/files/images/image_file.h"

#include "engine/files/file_name.h"

namespace espalier::files {
namespace {

/// The first bytes of the SGI format, two of its own, and of PNM: P and the digit of its kind.
bool isSgi(std::string_view bytes) {
  return bytes.starts_with("\x01\xda");
}

bool isPnm(std::string_view bytes) {
  return bytes.size() > 2 && bytes[0] == 'P' && std::string_view("2356").find(bytes[1]) != std::string_view::npos;
}

tl::expected<Image, std::string> readWithOpacity(std::string_view name, std::string_view bytes) {
  if (isJpeg(bytes)) {
    return readJpegImage(bytes);
  }
  if (isSgi(bytes)) {
    return readSgiImage(bytes);
  }
  if (isUtah(bytes)) {
    return readUtahImage(bytes);
  }
  if (isPnm(bytes)) {
    return readPnmImage(bytes);
  }
  if (endsIn(name, ".tga")) {
    return readTgaImage(bytes);
  }
  return tl::unexpected<std::string>("the format is unknown; use PNG, JPEG, SGI (.rgb), Utah (.rle), PNM or TGA");
}

}  // namespace

bool isPng(std::string_view bytes) {
  return bytes.starts_with("\x89PNG\r\n\x1a\n");
}

bool isJpeg(std::string_view bytes) {
  return bytes.starts_with("\xff\xd8\xff");
}

tl::expected<Image, std::string> blankImage(std::uint64_t width, std::uint64_t height) {
  if (width == 0 || height == 0) {
    return tl::unexpected<std::string>("the picture has no pixels");
  }
  if (width > kMostImagePixels || height > kMostImagePixels || width * height > kMostImagePixels) {
    return tl::unexpected("the picture has " + std::to_string(width) + " by " + std::to_string(height) +
                          " pixels; at most " + std::to_string(kMostImagePixels) + " pixels are read");
  }
  Image image{static_cast<int>(width), static_cast<int>(height), {}};
  image.pixels.assign(static_cast<std::size_t>(width * height) * 4, 255);
  return image;
}

tl::expected<Image, std::string> readImageFile(std::string_view name, std::string_view bytes, Opacity opacity) {
  if (isPng(bytes)) {
    return readPngImage(bytes, opacity);
  }
  auto image = readWithOpacity(name, bytes);
  if (image && opacity == Opacity::OverBlack) {
    for (std::size_t at = 3; at < image->pixels.size(); at += 4) {
      image->pixels[at] = 255;
    }
  }
  return image;
}

}  // namespace espalier::files
