#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "engine/files/length_unit.h"
#include "engine/files/points/point_cloud.h"

namespace espalier::files {

namespace {

/// Least bytes of a record of each point format.
constexpr std::array<std::size_t, 11> kFormatBytes{20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr std::uint8_t kFirstLongFormat = 6;  // formats with four bits for the number of returns
// keys of a GeoTIFF directory, and their values
constexpr std::uint64_t kModelType = 1024;
constexpr unsigned kGeographic = 2;
constexpr std::uint64_t kProjectedSystem = 3072;
constexpr std::uint64_t kProjectedUnit = 3076;
constexpr std::uint64_t kVerticalSystem = 4096;
constexpr std::uint64_t kVerticalUnit = 4099;
constexpr unsigned kUserDefined = 32767;
constexpr const char* kAsMetres = ". Convert it to a projection in metres";

/// Reads numbers of a file, little-endian. The caller checks the bounds.
class LasBytes {
 public:
  explicit LasBytes(std::string_view bytes) : bytes_(bytes) {}

  [[nodiscard]] std::uint64_t integer(std::uint64_t at, std::size_t width) const {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(bytes_[at + i])} << (8 * i);
    }
    return value;
  }
  [[nodiscard]] double real(std::uint64_t at) const { return std::bit_cast<double>(integer(at, 8)); }
  [[nodiscard]] double coordinate(std::uint64_t at) const {
    return static_cast<double>(static_cast<std::int32_t>(static_cast<std::uint32_t>(integer(at, 4))));
  }
  [[nodiscard]] std::string_view text(std::uint64_t at, std::size_t count) const { return bytes_.substr(at, count); }
  [[nodiscard]] std::uint64_t size() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

/// The header's information about the points.
struct LasHeader {
  std::uint64_t points = 0;  // where they begin
  std::uint64_t count = 0;
  std::uint64_t recordBytes = 0;
  std::uint8_t format = 0;
  core::Vec3 scale, offset;
};

tl::expected<LasHeader, std::string> readHeader(const LasBytes& file) {
  if (file.size() < 227) {
    return tl::unexpected(std::string("is cut short: it ends within the header of a LAS file. Get a complete copy"));
  }
  const std::uint64_t major = file.integer(24, 1);
  const std::uint64_t minor = file.integer(25, 1);
  if (major != 1 || minor < 2 || minor > 4) {
    return tl::unexpected("is of LAS version " + std::to_string(major) + "." + std::to_string(minor) +
                          ". Give a file of version 1.2, 1.3 or 1.4");
  }
  const std::uint64_t headerBytes = file.integer(94, 2);
  if (headerBytes < (minor == 4 ? 375U : 227U) || headerBytes > file.size()) {
    return tl::unexpected(
        std::string("has a header that is too short for its version or longer than the file. Get a "
                    "complete copy"));
  }
  const std::uint64_t format = file.integer(104, 1);
  if (format >= 64) {
    return tl::unexpected(std::string("is compressed (LAZ). Unpack it to LAS, as with laszip or las2las"));
  }
  if (format >= kFormatBytes.size()) {
    return tl::unexpected("has the point format " + std::to_string(format) +
                          ". Give a file with a format from 0 to 10");
  }
  LasHeader header{.points = file.integer(96, 4),
                   .count = file.integer(107, 4),
                   .recordBytes = file.integer(105, 2),
                   .format = static_cast<std::uint8_t>(format),
                   .scale = {file.real(131), file.real(139), file.real(147)},
                   .offset = {file.real(155), file.real(163), file.real(171)}};
  if (minor == 4) {
    header.count = file.integer(247, 8);
  }
  if (header.recordBytes < kFormatBytes[format]) {
    return tl::unexpected("has points of " + std::to_string(header.recordBytes) +
                          " bytes, and its point format needs " + std::to_string(kFormatBytes[format]) +
                          ". Get an undamaged copy");
  }
  for (const double number :
       {header.scale.x, header.scale.y, header.scale.z, header.offset.x, header.offset.y, header.offset.z}) {
    if (!(std::abs(number) < 1e100)) {
      return tl::unexpected(std::string("has a scale or an offset that is no number. Get an undamaged copy"));
    }
  }
  if (!(header.scale.x > 0 && header.scale.y > 0 && header.scale.z > 0)) {
    return tl::unexpected(std::string("has a scale that is not above 0. Get an undamaged copy"));
  }
  if (header.count > kMostCloudPoints) {
    return tl::unexpected("has " + std::to_string(header.count) + " points, more than " +
                          std::to_string(kMostCloudPoints) + ". Thin it out or cut it into tiles");
  }
  const bool isInside = header.points >= headerBytes && header.points <= file.size();
  const std::uint64_t room = isInside ? (file.size() - header.points) / header.recordBytes : 0;
  if (!isInside || room < header.count) {
    return tl::unexpected("is cut short: it holds " + std::to_string(room) + " of its " + std::to_string(header.count) +
                          " points. Get a complete copy");
  }
  return header;
}

/// Why the lengths are not metres, by the keys of a GeoTIFF directory; `isMetre` is set when they say so.
std::optional<std::string> problemOfKeys(const LasBytes& file, std::uint64_t at, std::uint64_t bytes, bool& isMetre) {
  std::map<std::uint64_t, unsigned> values;
  for (std::uint64_t entry = 8; entry + 8 <= bytes; entry += 8) {
    // another number here: the value is in another record
    if (file.integer(at + entry + 2, 2) == 0) {
      values.emplace(file.integer(at + entry, 2), static_cast<unsigned>(file.integer(at + entry + 6, 2)));
    }
  }
  const auto valueOf = [&](std::uint64_t key) {
    const auto found = values.find(key);
    return found == values.end() ? std::nullopt : std::optional(found->second);
  };
  if (valueOf(kModelType) == kGeographic) {
    return std::string("has coordinates in degrees") + kAsMetres;
  }
  // a system known by its number alone: its unit stands in a database
  const auto unitOf = [&](std::uint64_t unitKey, std::uint64_t systemKey) {
    const auto unit = valueOf(unitKey);
    const auto system = valueOf(systemKey);
    return unit || !system || *system == kUserDefined ? unit : unitOfSystem(*system);
  };
  const auto across = unitOf(kProjectedUnit, kProjectedSystem);
  for (const auto& unit : {across, unitOf(kVerticalUnit, kVerticalSystem)}) {
    if (unit && *unit != kMetre) {
      return notInMetres(*unit) + kAsMetres;
    }
  }
  isMetre = isMetre || across.has_value();
  return std::nullopt;
}

/// The same for a coordinate system as well-known text.
std::optional<std::string> problemOfText(std::string_view text, bool& isMetre) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (lower.find("foot") != std::string::npos || lower.find("feet") != std::string::npos) {
    return std::string("has lengths in feet") + kAsMetres;
  }
  if (lower.starts_with("geogcs") || lower.starts_with("geogcrs")) {
    return std::string("has coordinates in degrees") + kAsMetres;
  }
  isMetre = isMetre || lower.find("metre") != std::string::npos || lower.find("meter") != std::string::npos;
  return std::nullopt;
}

/// Looks for the coordinate system in the records before the points. The error: the unit is not the metre.
std::optional<std::string> readUnit(const LasBytes& file, const LasHeader& header, PointCloud& cloud) {
  bool isMetre = false;
  std::uint64_t at = file.integer(94, 2);
  for (std::uint64_t left = file.integer(100, 4); left > 0 && at + 54 <= header.points; --left) {
    const std::string_view user = file.text(at + 2, 16);
    const std::uint64_t record = file.integer(at + 18, 2);
    const std::uint64_t bytes = std::min(file.integer(at + 20, 2), header.points - at - 54);
    if (user.starts_with("LASF_Projection")) {
      auto problem = record == 34735  ? problemOfKeys(file, at + 54, bytes, isMetre)
                     : record == 2112 ? problemOfText(file.text(at + 54, bytes), isMetre)
                                      : std::nullopt;
      if (problem) {
        return problem;
      }
    }
    at += 54 + bytes;
  }
  cloud.lengthUnit = isMetre ? "m" : "";
  return std::nullopt;
}

}  // namespace

PointCloudOrProblem readLasPoints(std::string_view bytes) {
  const LasBytes file(bytes);
  const auto header = readHeader(file);
  if (!header) {
    return tl::unexpected(header.error());
  }
  PointCloud cloud;
  cloud.isNorthEastUp = true;
  if (auto problem = readUnit(file, *header, cloud)) {
    return tl::unexpected(std::move(*problem));
  }
  cloud.points.reserve(header->count);
  cloud.classes.reserve(header->count);
  cloud.returns.reserve(header->count);
  const bool isLong = header->format >= kFirstLongFormat;
  for (std::uint64_t i = 0; i < header->count; ++i) {
    const std::uint64_t at = header->points + i * header->recordBytes;
    const std::uint64_t echoes = file.integer(at + 14, 1);
    const std::uint64_t flags = file.integer(at + 15, 1);
    // the scanner's program has taken it out
    if (((flags >> (isLong ? 2U : 7U)) & 1U) != 0) {
      continue;
    }
    cloud.points.push_back({file.coordinate(at) * header->scale.x + header->offset.x,
                            file.coordinate(at + 4) * header->scale.y + header->offset.y,
                            file.coordinate(at + 8) * header->scale.z + header->offset.z});
    cloud.classes.push_back(static_cast<std::uint8_t>(isLong ? file.integer(at + 16, 1) : flags & 31U));
    const std::uint64_t count = isLong ? echoes >> 4U : (echoes >> 3U) & 7U;
    cloud.returns.push_back(static_cast<std::uint8_t>(std::max<std::uint64_t>(count, 1)));
  }
  if (cloud.points.empty() && header->count > 0) {
    return tl::unexpected(
        "has " + std::to_string(header->count) +
        " points, all marked as withheld, which says that they are not to be used. Choose another file");
  }
  return cloud;
}

PointCloudOrProblem readPoints(std::string_view bytes) {
  if (bytes.starts_with("LASF")) {
    return readLasPoints(bytes);
  }
  if (bytes.starts_with("ply")) {
    return readPlyPoints(bytes);
  }
  return tl::unexpected(std::string("is neither a LAS nor a PLY file. Convert it to one of them"));
}

}  // namespace espalier::files
