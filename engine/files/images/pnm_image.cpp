#include <algorithm>
#include <optional>

#include "engine/files/images/image_bytes.h"
#include "engine/files/images/image_file.h"

namespace espalier::files {
namespace {

/// Reads the numbers of a PNM file.
class PnmReader {
 public:
  PnmReader(std::string_view bytes, std::size_t begin) : bytes_(bytes), at_(begin) {}

  /// The next number, after blanks and comments; nothing at the end or before any other character.
  std::optional<std::uint32_t> number() {
    while (at_ < bytes_.size() && (isBlank(bytes_[at_]) || bytes_[at_] == '#')) {
      at_ = bytes_[at_] == '#' ? std::min(bytes_.find('\n', at_), bytes_.size()) : at_ + 1;
    }
    std::uint32_t value = 0;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9' && at_ - begin < 9) {
      value = value * 10 + static_cast<std::uint32_t>(bytes_[at_++] - '0');
    }
    return at_ == begin ? std::nullopt : std::optional(value);
  }
  std::optional<std::uint32_t> byte() {
    return at_ < bytes_.size() ? std::optional<std::uint32_t>(byteAt(bytes_, at_++)) : std::nullopt;
  }

 private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  std::string_view bytes_;
  std::size_t at_;
};

}  // namespace

tl::expected<Image, std::string> readPnmImage(std::string_view bytes) {
  const std::uint8_t kind = byteAt(bytes, 1);
  const bool isText = kind == '2' || kind == '3';
  const bool isColour = kind == '3' || kind == '6';
  PnmReader reader(bytes, 2);
  const auto width = reader.number();
  const auto height = reader.number();
  const auto largest = reader.number();
  if (!width || !height || !largest || *largest == 0 || *largest > 255) {
    return tl::unexpected<std::string>("the PNM picture must begin with width, height and a largest value up to 255");
  }
  // a number has a digit and a blank, the last one only a digit
  const std::uint64_t numbers = bytes.size() / (isText ? 2U : 1U) + 1;
  if (*width <= kMostImagePixels && *height <= kMostImagePixels && *width * *height <= kMostImagePixels &&
      *width * *height * (isColour ? 3U : 1U) > numbers) {
    return tl::unexpected<std::string>(kImageIsCutOff);
  }
  auto image = blankImage(*width, *height);
  if (!image) {
    return image;
  }
  if (!isText) {
    // one blank separates the header from the bytes
    (void)reader.byte();
  }
  for (std::size_t at = 0; at < image->pixels.size(); at += 4) {
    std::uint8_t* const pixel = &image->pixels[at];
    for (std::size_t channel = 0; channel < (isColour ? 3U : 1U); ++channel) {
      const auto value = isText ? reader.number() : reader.byte();
      if (!value) {
        return tl::unexpected<std::string>(kImageIsCutOff);
      }
      if (*value > *largest) {
        return tl::unexpected("the PNM picture has a value above its largest value, " + std::to_string(*largest));
      }
      pixel[channel] = static_cast<std::uint8_t>(*value * 255 / *largest);
    }
    if (!isColour) {
      pixel[1] = pixel[2] = pixel[0];
    }
  }
  return image;
}

}  // namespace espalier::files
