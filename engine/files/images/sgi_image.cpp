#include <algorithm>

#include "engine/files/images/image_bytes.h"
#include "engine/files/images/image_file.h"

namespace espalier::files {
namespace {

constexpr std::string_view kSgiSignature = "\x01\xda";

/// One row of one channel of a run-length encoded SGI image; false when it is damaged.
bool expandSgiRow(std::string_view row, std::size_t width, std::uint8_t* out) {
  constexpr std::uint8_t kCountBits = 0x7F;
  constexpr std::uint8_t kLiteralBit = 0x80;
  std::size_t at = 0;
  for (std::size_t x = 0; x < width;) {
    if (at >= row.size()) {
      return false;
    }
    const std::uint8_t control = byteAt(row, at++);
    const std::size_t count = control & kCountBits;
    if (count == 0 || count > width - x || at + ((control & kLiteralBit) != 0 ? count : 1) > row.size()) {
      return false;
    }
    for (std::size_t i = 0; i < count; ++i) {
      out[x++] = byteAt(row, (control & kLiteralBit) != 0 ? at++ : at);
    }
    at += (control & kLiteralBit) != 0 ? 0 : 1;
  }
  return true;
}

}  // namespace

tl::expected<Image, std::string> readSgiImage(std::string_view bytes) {
  constexpr std::size_t kHeaderBytes = 512;
  const bool isRunLength = byteAt(bytes, 2) == 1;
  const std::uint32_t dimensions = bigEndian(bytes, 4, 2);
  const std::uint32_t width = bigEndian(bytes, 6, 2);
  const std::uint32_t height = dimensions < 2 ? 1 : bigEndian(bytes, 8, 2);
  const std::uint32_t channels = dimensions < 3 ? 1 : bigEndian(bytes, 10, 2);
  if (!bytes.starts_with(kSgiSignature) || bytes.size() < kHeaderBytes || byteAt(bytes, 2) > 1) {
    return tl::unexpected<std::string>("this is not an SGI picture");
  }
  if (byteAt(bytes, 3) != 1) {
    return tl::unexpected<std::string>("the SGI picture has more than one byte a channel; only one byte is supported");
  }
  if (channels < 1 || channels > 4) {
    return tl::unexpected("the SGI picture has " + std::to_string(channels) + " channels; 1 to 4 are supported");
  }
  // two tables say where each row of each channel is and how many bytes it has
  const std::size_t rowCount = std::size_t{height} * channels;
  if (bytes.size() < kHeaderBytes + (isRunLength ? rowCount * 8 : rowCount * width)) {
    return tl::unexpected<std::string>(kImageIsCutOff);
  }
  auto blank = blankImage(width, height);
  if (!blank) {
    return blank;
  }
  Image& image = *blank;
  std::vector<std::uint8_t> row(width);
  for (std::uint32_t channel = 0; channel < channels; ++channel) {
    for (std::uint32_t y = 0; y < height; ++y) {
      const std::size_t index = std::size_t{channel} * height + y;
      if (isRunLength) {
        const std::size_t start = bigEndian(bytes, kHeaderBytes + index * 4, 4);
        const std::size_t length = bigEndian(bytes, kHeaderBytes + (rowCount + index) * 4, 4);
        if (start > bytes.size() || !expandSgiRow(bytes.substr(start, length), width, row.data())) {
          return tl::unexpected("row " + std::to_string(y) + " of channel " + std::to_string(channel) + " is damaged");
        }
      } else {
        const auto* const begin = bytes.data() + kHeaderBytes + index * width;
        std::transform(begin, begin + width, row.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
      }
      // the file begins with the bottom row; one channel is grey, the last of two or four is opacity
      std::uint8_t* const out = &image.pixels[std::size_t{height - 1 - y} * width * 4];
      for (std::size_t x = 0; x < width; ++x) {
        if (channels <= 2 && channel == 0) {
          std::fill_n(out + x * 4, 3, row[x]);
        } else {
          out[x * 4 + (channels == 2 ? 3 : channel)] = row[x];
        }
      }
    }
  }
  return blank;
}

}  // namespace espalier::files
