#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <string>

// after <cstdio>, which it needs and does not include
#include <jpeglib.h>

#include "engine/files/images/image_file.h"

namespace espalier::files {
namespace {

/// How libjpeg leaves a file that it cannot read: by a jump, without printing.
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

tl::expected<Image, std::string> readJpegImage(std::string_view bytes) {
  JpegRun run;
  tl::expected<Image, std::string> result;
  if (!beginJpeg(run, bytes)) {
    result = tl::unexpected(std::string("this is not a JPEG picture: ") + run.failure.message);
  } else if (result = blankImage(run.decoder.image_width, run.decoder.image_height); result) {
    if (finishJpeg(run, result->pixels.data())) {
      for (std::size_t at = 3; at < result->pixels.size(); at += 4) {
        result->pixels[at] = 255;
      }
    } else {
      result = tl::unexpected(std::string("the JPEG picture is damaged: ") + run.failure.message);
    }
  }
  jpeg_destroy_decompress(&run.decoder);
  return result;
}

}  // namespace espalier::files
