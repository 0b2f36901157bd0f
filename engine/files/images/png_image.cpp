#include <png.h>

#include <cstddef>
#include <string>

#include "engine/files/images/image_file.h"

namespace espalier::files {
namespace {

/// libpng's description of a picture, freed at the end.
class PngDescription {
 public:
  PngDescription() { image_.version = PNG_IMAGE_VERSION; }
  ~PngDescription() { png_image_free(&image_); }
  PngDescription(const PngDescription&) = delete;
  PngDescription& operator=(const PngDescription&) = delete;
  png_image* operator->() { return &image_; }
  png_image* get() { return &image_; }

 private:
  png_image image_{};
};

/// Moves packed red, green, blue to the front of four bytes a pixel; the opacity is 255.
void spreadToFourChannels(std::vector<std::uint8_t>& pixels) {
  for (std::size_t i = pixels.size() / 4; i-- > 0;) {
    for (std::size_t k = 3; k-- > 0;) {
      pixels[i * 4 + k] = pixels[i * 3 + k];
    }
    pixels[i * 4 + 3] = 255;
  }
}

}  // namespace

tl::expected<Image, std::string> readPngImage(std::string_view bytes, Opacity opacity) {
  PngDescription description;
  if (png_image_begin_read_from_memory(description.get(), bytes.data(), bytes.size()) == 0) {
    return tl::unexpected(std::string("this is not a PNG picture: ") + description->message);
  }
  auto image = blankImage(description->width, description->height);
  if (!image) {
    return image;
  }
  description->format = opacity == Opacity::Kept ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  const png_color black{0, 0, 0};
  if (png_image_finish_read(description.get(), opacity == Opacity::Kept ? nullptr : &black, image->pixels.data(), 0,
                            nullptr) == 0) {
    return tl::unexpected(std::string("the PNG picture is damaged: ") + description->message);
  }
  if (opacity == Opacity::OverBlack) {
    spreadToFourChannels(image->pixels);
  }
  return image;
}

}  // namespace espalier::files
