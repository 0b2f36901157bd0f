#include "engine/files/images/image_bytes.h"
#include "engine/files/images/image_file.h"

namespace espalier::files {

tl::expected<Image, std::string> readTgaImage(std::string_view bytes) {
  constexpr std::size_t kHeaderBytes = 18;
  constexpr std::uint8_t kTrueColour = 2;
  constexpr std::uint8_t kGrey = 3;
  constexpr std::uint8_t kRunLengthBit = 8;
  constexpr std::uint8_t kFromRightBit = 0x10;
  constexpr std::uint8_t kFromTopBit = 0x20;
  const std::uint8_t kind = byteAt(bytes, 2);
  const std::uint8_t plainKind = kind & static_cast<std::uint8_t>(~kRunLengthBit);
  const std::size_t pixelBytes = byteAt(bytes, 16) / 8U;
  const bool isGrey = plainKind == kGrey;
  if (bytes.size() < kHeaderBytes || (plainKind != kTrueColour && !isGrey) || byteAt(bytes, 1) != 0 ||
      !(isGrey ? pixelBytes == 1 : pixelBytes == 3 || pixelBytes == 4)) {
    return tl::unexpected<std::string>("this is not a TGA picture of true colour or grey");
  }
  const std::uint32_t width = littleEndian16(bytes, 12);
  const std::uint32_t height = littleEndian16(bytes, 14);
  const std::uint8_t order = byteAt(bytes, 17);
  // a packet of a run has a pixel for 128
  const std::uint64_t packets = bytes.size() / ((kind & kRunLengthBit) != 0 ? 1U + pixelBytes : pixelBytes);
  if (std::uint64_t{width} * height > packets * ((kind & kRunLengthBit) != 0 ? 128U : 1U)) {
    return tl::unexpected<std::string>(kImageIsCutOff);
  }
  auto blank = blankImage(width, height);
  if (!blank) {
    return blank;
  }
  Image& image = *blank;
  std::size_t at = kHeaderBytes + byteAt(bytes, 0);
  std::size_t left = 0;  // of a packet
  bool isRun = false;
  for (std::size_t i = 0; i < std::size_t{width} * height; ++i) {
    if ((kind & kRunLengthBit) != 0 && left == 0) {
      isRun = (byteAt(bytes, at) & 0x80U) != 0;
      left = (byteAt(bytes, at) & 0x7FU) + 1U;
      ++at;
    }
    if (at + pixelBytes > bytes.size()) {
      return tl::unexpected<std::string>(kImageIsCutOff);
    }
    const std::size_t fromLeft = (order & kFromRightBit) != 0 ? width - 1 - i % width : i % width;
    const std::size_t fromTop = (order & kFromTopBit) != 0 ? i / width : height - 1 - i / width;
    std::uint8_t* const out = &image.pixels[(fromTop * width + fromLeft) * 4];
    // blue, green, red
    for (std::size_t k = 0; k < 3; ++k) {
      out[k] = byteAt(bytes, isGrey ? at : at + 2 - k);
    }
    if (pixelBytes == 4) {
      out[3] = byteAt(bytes, at + 3);
    }
    left -= left > 0 ? 1 : 0;
    at += isRun && left > 0 ? 0 : pixelBytes;
  }
  return blank;
}

}  // namespace espalier::files
