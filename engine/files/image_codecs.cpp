#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <string>

// after <cstdio>, which it needs and does not include
#include <jpeglib.h>
#include <png.h>

#include "engine/files/image_file.h"

namespace espalier::language {
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

/// libjpeg ends by this on what it cannot read; it must not print.
struct JpegFailure {
  jpeg_error_mgr manager{};  // first: libjpeg knows only its address
  std::jmp_buf back{};
  char message[JMSG_LENGTH_MAX] = "";
};

[[noreturn]] void leaveJpeg(j_common_ptr common) {
  auto* const failure = reinterpret_cast<JpegFailure*>(common->err);
  common->err->format_message(common, failure->message);
  std::longjmp(failure->back, 1);
}

void ignoreJpegWarning(j_common_ptr) {}

// plain data only: a jump out of libjpeg passes no destructors here
struct JpegRun {
  jpeg_decompress_struct decoder{};
  JpegFailure failure;
};

bool beginJpeg(JpegRun& run, std::string_view bytes) {
  run.decoder.err = jpeg_std_error(&run.failure.manager);
  run.failure.manager.error_exit = leaveJpeg;
  run.failure.manager.output_message = ignoreJpegWarning;
  if (setjmp(run.failure.back) != 0) {
    return false;
  }
  jpeg_create_decompress(&run.decoder);
  jpeg_mem_src(&run.decoder, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&run.decoder, TRUE);
  return true;
}

bool finishJpeg(JpegRun& run, std::uint8_t* pixels) {
  if (setjmp(run.failure.back) != 0) {
    return false;
  }
  run.decoder.out_color_space = JCS_EXT_RGBX;
  run.decoder.dct_method = JDCT_ISLOW;  // the same numbers on every machine
  jpeg_start_decompress(&run.decoder);
  while (run.decoder.output_scanline < run.decoder.output_height) {
    JSAMPROW row = pixels + static_cast<std::size_t>(run.decoder.output_scanline) * run.decoder.output_width * 4;
    jpeg_read_scanlines(&run.decoder, &row, 1);
  }
  jpeg_finish_decompress(&run.decoder);
  return true;
}

}  // namespace

std::variant<Image, std::string> readPngImage(std::string_view bytes) {
  PngDescription description;
  if (png_image_begin_read_from_memory(description.get(), bytes.data(), bytes.size()) == 0) {
    return std::string("this is not a PNG picture: ") + description->message;
  }
  if (std::string problem = problemOfImageSize(description->width, description->height); !problem.empty()) {
    return problem;
  }
  description->format = PNG_FORMAT_RGBA;
  Image image{static_cast<int>(description->width), static_cast<int>(description->height), {}};
  image.pixels.resize(PNG_IMAGE_SIZE(*description.get()));
  if (png_image_finish_read(description.get(), nullptr, image.pixels.data(), 0, nullptr) == 0) {
    return std::string("the PNG picture is damaged: ") + description->message;
  }
  return image;
}

std::variant<Image, std::string> readJpegImage(std::string_view bytes) {
  JpegRun run;
  std::variant<Image, std::string> result;
  if (!beginJpeg(run, bytes)) {
    result = std::string("this is not a JPEG picture: ") + run.failure.message;
  } else if (std::string problem = problemOfImageSize(run.decoder.image_width, run.decoder.image_height);
             !problem.empty()) {
    result = std::move(problem);
  } else {
    Image image{static_cast<int>(run.decoder.image_width), static_cast<int>(run.decoder.image_height), {}};
    image.pixels.assign(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4, 255);
    if (finishJpeg(run, image.pixels.data())) {
      for (std::size_t at = 3; at < image.pixels.size(); at += 4) {
        image.pixels[at] = 255;
      }
      result = std::move(image);
    } else {
      result = std::string("the JPEG picture is damaged: ") + run.failure.message;
    }
  }
  jpeg_destroy_decompress(&run.decoder);
  return result;
}

}  // namespace espalier::language
