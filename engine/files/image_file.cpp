#include "engine/files/image_file.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace espalier::language {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kJpegSignature = "\xff\xd8\xff";
constexpr std::string_view kSgiSignature = "\x01\xda";
constexpr std::string_view kShortFile = "the file ends before the picture does";

bool endsIn(std::string_view name, std::string_view suffix) {
  return name.size() > suffix.size() &&
         std::ranges::equal(name.substr(name.size() - suffix.size()), suffix, {},
                            [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
}

std::uint8_t byteAt(std::string_view bytes, std::size_t i) {
  return i < bytes.size() ? static_cast<std::uint8_t>(bytes[i]) : std::uint8_t{0};
}

std::uint32_t bigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) {
    value = value << 8U | byteAt(bytes, at + i);
  }
  return value;
}

std::uint32_t littleEndian16(std::string_view bytes, std::size_t at) {
  return byteAt(bytes, at) | static_cast<std::uint32_t>(byteAt(bytes, at + 1)) << 8U;
}

Image blank(std::uint32_t width, std::uint32_t height) {
  Image image{static_cast<int>(width), static_cast<int>(height), {}};
  image.pixels.assign(std::size_t{width} * height * 4, 255);
  return image;
}

/// One row of one channel of a run-length encoded SGI image; false when the bytes or the row end too early.
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

bool isPng(std::string_view bytes) {
  return bytes.starts_with(kPngSignature);
}

bool isJpeg(std::string_view bytes) {
  return bytes.starts_with(kJpegSignature);
}

std::string problemOfImageSize(std::uint64_t width, std::uint64_t height) {
  const std::string size =
      "the picture has " + std::to_string(width) + " by " + std::to_string(height) + " points; at most ";
  if (width == 0 || height == 0) {
    return "the picture has no points";
  }
  if (width > kMostImageSide || height > kMostImageSide) {
    return size + std::to_string(kMostImageSide) + " each way are read";
  }
  return width * height > kMostImagePixels ? size + std::to_string(kMostImagePixels) + " in all are read" : "";
}

std::variant<Image, std::string> readSgiImage(std::string_view bytes) {
  constexpr std::size_t kHeaderBytes = 512;
  const bool isRunLength = byteAt(bytes, 2) == 1;
  const std::uint32_t dimensions = bigEndian(bytes, 4, 2);
  const std::uint32_t width = bigEndian(bytes, 6, 2);
  const std::uint32_t height = dimensions < 2 ? 1 : bigEndian(bytes, 8, 2);
  const std::uint32_t channels = dimensions < 3 ? 1 : bigEndian(bytes, 10, 2);
  if (!bytes.starts_with(kSgiSignature) || bytes.size() < kHeaderBytes || byteAt(bytes, 2) > 1) {
    return "this is not an SGI picture";
  }
  if (byteAt(bytes, 3) != 1) {
    return "the SGI picture has more than one byte a channel; such pictures are not read";
  }
  if (channels < 1 || channels > 4) {
    return "the SGI picture has " + std::to_string(channels) + " channels; 1 to 4 are read";
  }
  if (std::string problem = problemOfImageSize(width, height); !problem.empty()) {
    return problem;
  }
  // two tables say where each row of each channel is and how many bytes it has
  const std::size_t rowCount = std::size_t{height} * channels;
  if (bytes.size() < kHeaderBytes + (isRunLength ? rowCount * 8 : rowCount * width)) {
    return std::string(kShortFile);
  }
  Image image = blank(width, height);
  std::vector<std::uint8_t> row(width);
  for (std::uint32_t channel = 0; channel < channels; ++channel) {
    for (std::uint32_t y = 0; y < height; ++y) {
      const std::size_t index = std::size_t{channel} * height + y;
      if (isRunLength) {
        const std::size_t start = bigEndian(bytes, kHeaderBytes + index * 4, 4);
        const std::size_t length = bigEndian(bytes, kHeaderBytes + (rowCount + index) * 4, 4);
        if (start > bytes.size() || !expandSgiRow(bytes.substr(start, length), width, row.data())) {
          return "row " + std::to_string(y) + " of channel " + std::to_string(channel) + " is damaged";
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
  return image;
}

std::variant<Image, std::string> readTgaImage(std::string_view bytes) {
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
    return "this is no TGA picture of true colour or grey";
  }
  const std::uint32_t width = littleEndian16(bytes, 12);
  const std::uint32_t height = littleEndian16(bytes, 14);
  const std::uint8_t order = byteAt(bytes, 17);
  if (std::string problem = problemOfImageSize(width, height); !problem.empty()) {
    return problem;
  }
  Image image = blank(width, height);
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
      return std::string(kShortFile);
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
  return image;
}

std::variant<Image, std::string> readImageFile(std::string_view name, std::string_view bytes) {
  if (isPng(bytes)) {
    return readPngImage(bytes);
  }
  if (isJpeg(bytes)) {
    return readJpegImage(bytes);
  }
  if (bytes.starts_with(kSgiSignature)) {
    return readSgiImage(bytes);
  }
  if (endsIn(name, ".tga")) {
    return readTgaImage(bytes);
  }
  return "it is no picture of a kind that is read: PNG, JPEG, SGI (.rgb) or TGA";
}

}  // namespace espalier::language
