#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

// after <cstdio>, which it needs and does not include
#include <jpeglib.h>

#include "engine/core/work_meter.h"
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

/// Each scan of a progressive picture goes over all of its pixels, and a few bytes make a scan. Programs write ten.
constexpr int kMostScans = 100;

void boundScans(j_common_ptr common) {
  const bool isTooLong = reinterpret_cast<j_decompress_ptr>(common)->input_scan_number > kMostScans;
  if (isTooLong || core::isWorkStopped()) {
    auto* const failure = reinterpret_cast<JpegFailure*>(common->err);
    std::snprintf(failure->message, sizeof failure->message, "it has more than %d scans", kMostScans);
    std::longjmp(failure->back, 1);
  }
}

// plain data only: a jump out of libjpeg passes no destructors here
struct JpegRun {
  jpeg_decompress_struct decoder{};
  jpeg_progress_mgr progress{};
  JpegFailure failure;
};

/// Gives back what libjpeg has taken, also when there is no memory for the picture.
class JpegEnd {
 public:
  explicit JpegEnd(JpegRun& run) : run_(&run) {}
  ~JpegEnd() {
    core::giveMemory(taken_);
    jpeg_destroy_decompress(&run_->decoder);
  }
  JpegEnd(const JpegEnd&) = delete;
  JpegEnd& operator=(const JpegEnd&) = delete;

  /// libjpeg keeps two bytes for each pixel and channel of a picture of several scans.
  void takeForScans() {
    const jpeg_decompress_struct& decoder = run_->decoder;
    if (decoder.progressive_mode != 0 || decoder.comps_in_scan < decoder.num_components) {
      const std::uint64_t bytes = std::uint64_t{decoder.image_width} * decoder.image_height *
                                  static_cast<std::uint64_t>(decoder.num_components) * 2;
      core::takeMemory(bytes);
      taken_ = bytes;
    }
  }

 private:
  JpegRun* run_;
  std::uint64_t taken_ = 0;  // bytes that the meter of this thread counts
};

bool beginJpeg(JpegRun& run, std::string_view bytes) {
  run.decoder.err = jpeg_std_error(&run.failure.manager);
  run.failure.manager.error_exit = leaveJpeg;
  run.failure.manager.output_message = ignoreJpegWarning;
  if (setjmp(run.failure.back) != 0) {
    return false;
  }
  jpeg_create_decompress(&run.decoder);
  run.progress.progress_monitor = boundScans;
  run.decoder.progress = &run.progress;
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
  JpegEnd end(run);
  tl::expected<Image, std::string> result;
  if (!beginJpeg(run, bytes)) {
    result = tl::unexpected(std::string("this is not a JPEG picture: ") + run.failure.message);
  } else if (result = blankImage(run.decoder.image_width, run.decoder.image_height); result) {
    end.takeForScans();
    if (finishJpeg(run, result->pixels.data())) {
      for (std::size_t at = 3; at < result->pixels.size(); at += 4) {
        result->pixels[at] = 255;
      }
    } else {
      result = tl::unexpected(std::string("the JPEG picture is damaged: ") + run.failure.message);
    }
  }
  core::pollWork();
  return result;
}

}  // namespace espalier::files
