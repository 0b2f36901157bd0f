#include <algorithm>
#include <array>

#include "engine/files/images/image_bytes.h"
#include "engine/files/images/image_file.h"

namespace espalier::files {
namespace {

// Thomas, "Design of the Utah RLE Format", University of Utah, 1986
constexpr std::size_t kUtahHeaderBytes = 15;
constexpr std::uint8_t kHasNoBackground = 2;
constexpr std::uint8_t kHasOpacity = 4;
constexpr std::uint8_t kHasComment = 8;

enum class UtahOperation : std::uint8_t {
  SkipLines = 1,
  SetChannel = 2,
  SkipPixels = 3,
  Bytes = 5,
  Run = 6,
  End = 7,
};

struct UtahHeader {
  std::uint32_t left = 0, bottom = 0, width = 0, height = 0;
  std::uint8_t flags = 0, channels = 0;
  std::size_t mapBegin = 0;  // of the colour maps, 16 bits an entry
  std::size_t mapCount = 0;  // maps: of all channels together, or of each
  std::size_t mapLength = 0;
  std::size_t begin = 0;  // of the operations
};

UtahHeader utahHeaderOf(std::string_view bytes) {
  UtahHeader header{littleEndian16(bytes, 2), littleEndian16(bytes, 4), littleEndian16(bytes, 6),
                    littleEndian16(bytes, 8), byteAt(bytes, 10),        byteAt(bytes, 11)};
  header.mapCount = byteAt(bytes, 13);
  header.mapLength = std::size_t{1} << std::min<std::size_t>(byteAt(bytes, 14), 16);
  // the colour of the background fills the header up to an even number of bytes
  const bool hasBackground = (header.flags & kHasNoBackground) == 0;
  header.mapBegin = kUtahHeaderBytes + 1 + (hasBackground ? std::size_t{header.channels} / 2 * 2 : 0);
  header.begin = header.mapBegin + header.mapCount * header.mapLength * 2;
  if ((header.flags & kHasComment) != 0) {
    const std::size_t length = littleEndian16(bytes, header.begin);
    header.begin += 2 + length + length % 2;
  }
  return header;
}

/// The colour that an entry of channel `channel` stands for.
std::uint8_t mappedUtah(std::string_view bytes, const UtahHeader& header, std::size_t channel, std::uint8_t value) {
  if (header.mapCount == 0 || value >= header.mapLength) {
    return value;
  }
  const std::size_t map = std::min(channel, header.mapCount - 1);
  return static_cast<std::uint8_t>(littleEndian16(bytes, header.mapBegin + (map * header.mapLength + value) * 2) >> 8U);
}

}  // namespace

tl::expected<Image, std::string> readUtahImage(std::string_view bytes) {
  const UtahHeader header = utahHeaderOf(bytes);
  if (bytes.size() < kUtahHeaderBytes || !isUtah(bytes) || byteAt(bytes, 12) != 8) {
    return tl::unexpected<std::string>("this is not a Utah picture of 8 bits a channel");
  }
  const std::size_t channels = header.channels;
  if (channels != 1 && channels != 3) {
    return tl::unexpected("the Utah picture has " + std::to_string(channels) + " channels; 1 and 3 are supported");
  }
  auto blank = blankImage(header.width, header.height);
  if (!blank) {
    return blank;
  }
  Image& image = *blank;
  // untouched pixels have the background's colour, or are black; with an opacity channel nothing is opaque at first
  for (std::size_t i = 0; i < image.pixels.size(); i += 4) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint8_t value =
          (header.flags & kHasNoBackground) != 0 ? 0 : byteAt(bytes, kUtahHeaderBytes + (channels == 1 ? 0 : k));
      image.pixels[i + k] = mappedUtah(bytes, header, k, value);
    }
    image.pixels[i + 3] = (header.flags & kHasOpacity) != 0 ? 0 : 255;
  }

  constexpr std::size_t kOpacityChannel = 255;
  std::size_t x = 0;
  std::size_t y = 0;  // from the bottom row
  std::size_t channel = 0;
  const auto put = [&](std::uint8_t value) {
    if (x < header.width && y < header.height) {
      std::uint8_t* const out = &image.pixels[((header.height - 1 - y) * header.width + x) * 4];
      if (channel == kOpacityChannel) {
        out[3] = value;
      } else {
        for (std::size_t k = 0; k < 3; ++k) {
          out[k] = channels == 1 || k == channel ? mappedUtah(bytes, header, k, value) : out[k];
        }
      }
    }
    ++x;
  };
  for (std::size_t at = header.begin;;) {
    if (at + 2 > bytes.size()) {
      return tl::unexpected<std::string>(kImageIsCutOff);
    }
    const bool isLong = (byteAt(bytes, at) & 0x40U) != 0;
    const auto operation = static_cast<UtahOperation>(byteAt(bytes, at) & 0x3FU);
    const std::size_t operand = isLong ? littleEndian16(bytes, at + 2) : byteAt(bytes, at + 1);
    at += isLong ? 4 : 2;
    switch (operation) {
      case UtahOperation::SkipLines:
        y += operand;
        x = 0;
        break;
      case UtahOperation::SetChannel:
        channel = operand;
        x = 0;
        break;
      case UtahOperation::SkipPixels:
        x += operand;
        break;
      case UtahOperation::Bytes:
        if (at + operand + 1 > bytes.size()) {
          return tl::unexpected<std::string>(kImageIsCutOff);
        }
        for (std::size_t i = 0; i <= operand; ++i) {
          put(byteAt(bytes, at + i));
        }
        at += operand + 1 + (operand + 1) % 2;
        break;
      case UtahOperation::Run:
        for (std::size_t i = 0; i <= operand; ++i) {
          put(byteAt(bytes, at));
        }
        at += 2;
        break;
      case UtahOperation::End:
        return blank;
      default:
        return tl::unexpected("byte " + std::to_string(at) + " of the Utah picture is no operation");
    }
  }
}

bool isUtah(std::string_view bytes) {
  return bytes.starts_with("\x52\xcc");
}

}  // namespace espalier::files
