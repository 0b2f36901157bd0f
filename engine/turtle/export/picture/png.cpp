#include "engine/turtle/export/picture/png.h"

#include <png.h>

#include <algorithm>
#include <vector>

#include "engine/turtle/export/picture/colour_table.h"

namespace espalier::turtle {

namespace {

/// libpng's description of a picture, freed at the end.
class Description {
 public:
  Description() { image_.version = PNG_IMAGE_VERSION; }
  ~Description() { png_image_free(&image_); }
  Description(const Description&) = delete;
  Description& operator=(const Description&) = delete;
  png_image* operator->() { return &image_; }
  png_image* get() { return &image_; }

 private:
  png_image image_{};
};

std::optional<std::string> write(Description& description, const void* pixels, const void* colours,
                                 core::ByteSink& sink) {
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(*description.get());
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(description.get(), bytes.data(), &size, 0, pixels, 0, colours) == 0) {
    return std::string("the picture could not be encoded: ") + description->message;
  }
  sink.write(std::string_view(bytes).substr(0, size));
  return std::nullopt;
}

std::optional<std::string> writeIndexed(Description& description, const PictureImage& image, int maximumColours,
                                        core::ByteSink& sink) {
  const IndexedPicture picture = indexedPicture(image, maximumColours);
  std::vector<std::uint8_t> colours;
  for (const Colour& colour : picture.colours) {
    colours.insert(colours.end(), {colour.red, colour.green, colour.blue});
  }
  description->format = PNG_FORMAT_RGB_COLORMAP;
  description->colormap_entries = static_cast<png_uint_32>(picture.colours.size());
  return write(description, picture.indices.data(), colours.data(), sink);
}

}  // namespace

std::optional<std::string> writePng(const PictureImage& image, core::ByteSink& sink, int maximumColours) {
  Description description;
  description->width = static_cast<png_uint_32>(image.width);
  description->height = static_cast<png_uint_32>(image.height);
  if (maximumColours > 0) {
    return writeIndexed(description, image, maximumColours, sink);
  }
  bool isOpaque = true;
  for (std::size_t at = 3; at < image.pixels.size(); at += 4) {
    isOpaque = isOpaque && image.pixels[at] == 255;
  }
  if (!isOpaque) {
    description->format = PNG_FORMAT_RGBA;
    return write(description, image.pixels.data(), nullptr, sink);
  }
  std::vector<std::uint8_t> opaque(image.pixels.size() / 4 * 3);
  for (std::size_t i = 0; i < image.pixels.size() / 4; ++i) {
    std::copy_n(&image.pixels[i * 4], 3, &opaque[i * 3]);
  }
  description->format = PNG_FORMAT_RGB;
  return write(description, opaque.data(), nullptr, sink);
}

}  // namespace espalier::turtle
