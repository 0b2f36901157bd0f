#include "environment/published/image_file.h"

#include <png.h>

#include <algorithm>
#include <optional>

namespace espalier::environment {

namespace {

constexpr std::uint64_t kMaximumPixelCount = std::uint64_t{1} << 26;
constexpr std::string_view kPngStart{"\x89PNG\r\n\x1a\n", 8};
constexpr std::string_view kSgiStart{"\x01\xda", 2};

std::uint8_t byteAt(std::string_view text, std::size_t i) {
  return static_cast<std::uint8_t>(text[i]);
}

bool isTooLarge(std::uint64_t width, std::uint64_t height) {
  return width == 0 || height == 0 || width > kMaximumPixelCount || height > kMaximumPixelCount ||
         width * height > kMaximumPixelCount;
}

std::string sizeProblem() {
  return "has no pixels or more than 67108864";
}

Image emptyImage(std::size_t width, std::size_t height) {
  return {width, height, std::vector<std::uint8_t>(width * height * 3)};
}

std::variant<Image, std::string> decodePng(std::string_view content) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, content.data(), content.size()) == 0) {
    return std::string("is a damaged PNG file: ") + png.message;
  }
  if (isTooLarge(png.width, png.height)) {
    png_image_free(&png);
    return sizeProblem();
  }
  png.format = PNG_FORMAT_RGB;
  Image image = emptyImage(png.width, png.height);
  // a negative stride puts the first row of the file last
  const auto stride = -static_cast<png_int_32>(png.width * 3);
  const png_color black{0, 0, 0};
  if (png_image_finish_read(&png, &black, image.bytes.data(), stride, nullptr) == 0) {
    return std::string("is a damaged PNG file: ") + png.message;
  }
  return image;
}

/// One row of one channel of a run-length SGI image; false when it is damaged.
bool decodeSgiRow(std::string_view packed, std::size_t width, std::uint8_t* row) {
  std::size_t x = 0;
  for (std::size_t i = 0; i < packed.size();) {
    const std::uint8_t head = byteAt(packed, i++);
    const std::size_t count = head & 0x7FU;
    if (count == 0) {
      break;
    }
    const bool isLiteral = (head & 0x80U) != 0;
    if (x + count > width || i + (isLiteral ? count : 1) > packed.size()) {
      return false;
    }
    for (std::size_t k = 0; k < count; ++k) {
      row[x++] = byteAt(packed, isLiteral ? i + k : i);
    }
    i += isLiteral ? count : 1;
  }
  return x == width;
}

std::variant<Image, std::string> decodeSgi(std::string_view content) {
  constexpr std::size_t kHeaderBytes = 512;
  const auto big = [&](std::size_t at, std::size_t bytes) {
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      value = value * 256 + byteAt(content, at + i);
    }
    return value;
  };
  if (content.size() < kHeaderBytes) {
    return std::string("is a damaged SGI image: its header is cut off");
  }
  const bool isRunLength = byteAt(content, 2) == 1;
  if (byteAt(content, 3) != 1) {
    return std::string("is an SGI image with two bytes a channel: one byte is read");
  }
  const std::size_t dimensions = big(4, 2);
  const std::size_t width = big(6, 2);
  const std::size_t height = dimensions < 2 ? 1 : big(8, 2);
  const std::size_t channels = dimensions < 3 ? 1 : big(10, 2);
  if (isTooLarge(width, height) || channels == 0) {
    return sizeProblem();
  }
  Image image = emptyImage(width, height);
  std::vector<std::uint8_t> row(width);
  // grey images have the same value in all three channels
  const std::size_t used = channels < 3 ? 1 : 3;
  for (std::size_t channel = 0; channel < used; ++channel) {
    for (std::size_t y = 0; y < height; ++y) {
      const std::size_t number = channel * height + y;
      std::size_t offset = kHeaderBytes + number * width;
      std::size_t length = width;
      if (isRunLength) {
        const std::size_t table = kHeaderBytes + 4 * number;
        const std::size_t lengths = table + 4 * height * channels;
        if (lengths + 4 > content.size()) {
          return std::string("is a damaged SGI image: its tables are cut off");
        }
        offset = big(table, 4);
        length = big(lengths, 4);
      }
      if (offset > content.size() || length > content.size() - offset) {
        return std::string("is a damaged SGI image: its rows are cut off");
      }
      const std::string_view packed = content.substr(offset, length);
      if (!isRunLength) {
        std::transform(packed.begin(), packed.end(), row.begin(), [](char c) { return static_cast<std::uint8_t>(c); });
      } else if (!decodeSgiRow(packed, width, row.data())) {
        return std::string("is a damaged SGI image: a row has a wrong length");
      }
      for (std::size_t x = 0; x < width; ++x) {
        for (std::size_t k = channel; k < (used == 1 ? 3 : channel + 1); ++k) {
          image.bytes[(y * width + x) * 3 + k] = row[x];
        }
      }
    }
  }
  return image;
}

/// Reads the numbers of a PNM file.
class PnmReader {
 public:
  explicit PnmReader(std::string_view content) : content_(content) {}

  /// The next number, after blanks and comments; nothing at the end or at something else.
  std::optional<std::uint32_t> number() {
    while (at_ < content_.size() && (isBlank(content_[at_]) || content_[at_] == '#')) {
      if (content_[at_] == '#') {
        at_ = std::min(content_.find('\n', at_), content_.size());
      } else {
        ++at_;
      }
    }
    std::uint32_t value = 0;
    const std::size_t begin = at_;
    while (at_ < content_.size() && content_[at_] >= '0' && content_[at_] <= '9' && at_ - begin < 9) {
      value = value * 10 + static_cast<std::uint32_t>(content_[at_++] - '0');
    }
    return at_ == begin ? std::nullopt : std::optional(value);
  }
  std::optional<std::uint32_t> byte() {
    return at_ < content_.size() ? std::optional<std::uint32_t>(byteAt(content_, at_++)) : std::nullopt;
  }
  void skip(std::size_t count) { at_ += count; }

 private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  std::string_view content_;
  std::size_t at_ = 0;
};

std::variant<Image, std::string> decodePnm(std::string_view content) {
  const char kind = content[1];
  const bool isText = kind == '2' || kind == '3';
  const bool isColour = kind == '3' || kind == '6';
  PnmReader reader(content);
  reader.skip(2);
  const auto width = reader.number();
  const auto height = reader.number();
  const auto largest = reader.number();
  if (!width || !height || !largest || *largest == 0 || *largest > 255) {
    return std::string("is a damaged PNM file: its first line must have width, height and a largest value up to 255");
  }
  if (isTooLarge(*width, *height)) {
    return sizeProblem();
  }
  if (!isText) {
    reader.skip(1);
  }
  Image image = emptyImage(*width, *height);
  for (std::size_t line = 0; line < *height; ++line) {
    for (std::size_t x = 0; x < *width; ++x) {
      std::uint8_t* pixel = image.bytes.data() + ((*height - 1 - line) * *width + x) * 3;
      for (std::size_t channel = 0; channel < (isColour ? 3U : 1U); ++channel) {
        const auto value = isText ? reader.number() : reader.byte();
        if (!value || *value > *largest) {
          return std::string("is a damaged PNM file: its pixels are cut off or beyond the largest value");
        }
        pixel[channel] = static_cast<std::uint8_t>(*value * 255 / *largest);
      }
      if (!isColour) {
        pixel[1] = pixel[2] = pixel[0];
      }
    }
  }
  return image;
}

}  // namespace

std::variant<Image, std::string> decodeImage(std::string_view content) {
  if (content.substr(0, kPngStart.size()) == kPngStart) {
    return decodePng(content);
  }
  if (content.substr(0, kSgiStart.size()) == kSgiStart) {
    return decodeSgi(content);
  }
  if (content.size() > 2 && content[0] == 'P' && std::string_view("2356").find(content[1]) != std::string_view::npos) {
    return decodePnm(content);
  }
  return std::string("is no image that can be read: use PNG, SGI rgb or PNM");
}

}  // namespace espalier::environment
