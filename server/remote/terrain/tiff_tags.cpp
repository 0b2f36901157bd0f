#include "server/remote/terrain/tiff_tags.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace espalier::server {

namespace {

/// Pixel scale, tie points, matrix, keys with their numbers and texts; metadata and the number of no height of GDAL.
constexpr std::array<std::uint64_t, 8> kTags = {33550, 33922, 34264, 34735, 34736, 34737, 42112, 42113};
/// Bytes of a value by its kind; 0: unknown.
constexpr std::array<std::uint64_t, 19> kBytes = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};

class TiffBytes {
 public:
  explicit TiffBytes(std::string_view bytes) : bytes_(bytes), isBigEndian_(bytes.starts_with("MM")) {}

  [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }
  [[nodiscard]] bool has(std::uint64_t at, std::uint64_t count) const {
    return count <= bytes_.size() && at <= bytes_.size() - count;
  }
  /// The whole number of `count` bytes, which are there.
  [[nodiscard]] std::uint64_t number(std::uint64_t at, std::size_t count) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) {
      value = value << 8U | static_cast<unsigned char>(bytes_[at + (isBigEndian_ ? i : count - 1 - i)]);
    }
    return value;
  }

 private:
  std::string_view bytes_;
  bool isBigEndian_;
};

}  // namespace

bool hasWholeGeoTags(std::string_view bytes) {
  const TiffBytes file(bytes);
  if (!(bytes.starts_with("II") || bytes.starts_with("MM")) || !file.has(0, 16)) {
    return true;
  }
  // the large form of the format has wider numbers
  const bool isLarge = file.number(2, 2) == 43;
  const std::size_t width = isLarge ? 8 : 4;
  const std::size_t countWidth = isLarge ? 8 : 2;
  const std::size_t entryBytes = isLarge ? 20 : 12;
  const std::uint64_t directory = isLarge ? file.number(8, 8) : file.number(4, 4);
  if (!file.has(directory, countWidth)) {
    return true;
  }
  const std::uint64_t count = file.number(directory, countWidth);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t entry = directory + countWidth + i * entryBytes;
    if (!file.has(entry, entryBytes)) {
      return true;
    }
    const std::uint64_t kind = file.number(entry + 2, 2);
    const std::uint64_t values = file.number(entry + 4, width);
    const std::uint64_t one = kind < kBytes.size() ? kBytes[kind] : 0;
    if (std::ranges::find(kTags, file.number(entry, 2)) == kTags.end() || one == 0) {
      continue;
    }
    const bool isInside = values <= width / one ||
                          (values <= file.size() && file.has(file.number(entry + 4 + width, width), values * one));
    if (!isInside) {
      return false;
    }
  }
  return true;
}

}  // namespace espalier::server
