#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "engine/files/points/point_cloud.h"

namespace espalier::files {

namespace {

/// How the numbers of a file are written.
enum class PlyFormat : std::uint8_t { Ascii, LittleEndian, BigEndian };

struct PlyType {
  std::string_view name;
  std::size_t bytes;
  char kind;  // i: signed, u: unsigned, f: real
};
constexpr PlyType kTypes[] = {{"char", 1, 'i'},  {"int8", 1, 'i'},    {"uchar", 1, 'u'},  {"uint8", 1, 'u'},
                              {"short", 2, 'i'}, {"int16", 2, 'i'},   {"ushort", 2, 'u'}, {"uint16", 2, 'u'},
                              {"int", 4, 'i'},   {"int32", 4, 'i'},   {"uint", 4, 'u'},   {"uint32", 4, 'u'},
                              {"float", 4, 'f'}, {"float32", 4, 'f'}, {"double", 8, 'f'}, {"float64", 8, 'f'}};
constexpr std::size_t kMostProperties = 1000;

struct PlyProperty {
  PlyType type;
  std::size_t axis = 3;  // 0 to 2: a coordinate; 3: none
};

/// The vertices as the header describes them.
struct PlyHeader {
  PlyFormat format = PlyFormat::Ascii;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  std::size_t body = 0;  // first byte behind the header
};

/// The words of a line, at most five.
std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; words.size() < 5;) {
    at = line.find_first_not_of(" \t\r", at);
    if (at == std::string_view::npos) {
      break;
    }
    const std::size_t end = std::min(line.find_first_of(" \t\r", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

tl::unexpected<std::string> refused(std::size_t line, const std::string& what) {
  return tl::unexpected("has a header that cannot be used, line " + std::to_string(line) + ": " + what);
}

/// Adds a property of the vertices.
std::optional<std::string> addProperty(const std::vector<std::string_view>& words, PlyHeader& header) {
  if (words.size() != 3) {
    return "vertices with lists are not read. Write them with single numbers";
  }
  const auto* const type = std::ranges::find(kTypes, words[1], &PlyType::name);
  if (type == std::end(kTypes)) {
    return "the type '" + std::string(words[1].substr(0, 40)) + "' is unknown. Write float or double";
  }
  if (header.properties.size() == kMostProperties) {
    return "vertices have more than " + std::to_string(kMostProperties) + " properties. Leave some out";
  }
  const std::array<std::string_view, 3> names{"x", "y", "z"};
  header.properties.push_back({*type, static_cast<std::size_t>(std::ranges::find(names, words[2]) - names.begin())});
  return std::nullopt;
}

tl::expected<PlyHeader, std::string> readHeader(std::string_view bytes) {
  PlyHeader header;
  std::string_view element;  // that properties belong to; empty: none yet
  bool hasVertices = false;
  std::size_t number = 0;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos) {
      break;
    }
    const std::vector<std::string_view> words = wordsOf(bytes.substr(at, end - at));
    at = end + 1;
    ++number;
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info" || number == 1) {
      continue;
    }
    if (words[0] == "end_header") {
      std::array<bool, 4> has{};
      for (const PlyProperty& property : header.properties) {
        has[property.axis] = true;
      }
      if (!hasVertices || !has[0] || !has[1] || !has[2]) {
        return refused(number, "there is no element 'vertex' with x, y and z. Give a file with points");
      }
      header.body = at;
      return header;
    }
    if (words[0] == "format") {
      const std::string_view name = words.size() > 1 ? words[1] : std::string_view();
      if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian") {
        return refused(number, "the format is not ascii, binary_little_endian or binary_big_endian. Write one of them");
      }
      header.format = name == "ascii"                  ? PlyFormat::Ascii
                      : name == "binary_little_endian" ? PlyFormat::LittleEndian
                                                       : PlyFormat::BigEndian;
    } else if (words[0] == "element" && words.size() == 3) {
      element = words[1];
      if (!hasVertices && element != "vertex") {
        return refused(number, "the first element is '" + std::string(element.substr(0, 40)) +
                                   "'. Write the element 'vertex' first");
      }
      if (element == "vertex") {
        const auto [rest, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), header.count);
        if (hasVertices || error != std::errc() || rest != words[2].data() + words[2].size()) {
          return refused(number, "expected one element 'vertex' with the number of points. Correct the number");
        }
        hasVertices = true;
      }
    } else if (words[0] == "property" && !element.empty()) {
      if (element == "vertex") {
        if (auto problem = addProperty(words, header)) {
          return refused(number, *problem);
        }
      }
    } else {
      return refused(number, "'" + std::string(words[0].substr(0, 40)) + "' is not expected there. Give a PLY file");
    }
  }
  return tl::unexpected(std::string("is cut short: its header has no end_header. Get a complete copy"));
}

/// A binary number of a type at `at`.
double numberAt(std::string_view bytes, std::size_t at, const PlyType& type, bool isBigEndian) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < type.bytes; ++i) {
    const auto byte = static_cast<unsigned char>(bytes[at + (isBigEndian ? type.bytes - 1 - i : i)]);
    bits |= std::uint64_t{byte} << (8 * i);
  }
  if (type.kind == 'f') {
    return type.bytes == 8 ? std::bit_cast<double>(bits)
                           : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }
  if (type.kind == 'i') {
    // the sign of the shorter number
    const std::uint64_t sign = std::uint64_t{1} << (8 * type.bytes - 1);
    return static_cast<double>(static_cast<std::int64_t>((bits ^ sign) - sign));
  }
  return static_cast<double>(bits);
}

/// The vertices of an ascii body, one in a line. Empty lines are passed over. `line` is the number of the first line.
std::optional<std::string> readAscii(std::string_view body, const PlyHeader& header, std::size_t line,
                                     PointCloud& cloud) {
  const auto isSpace = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  const auto cutShort = [&] {
    return "is cut short: it holds " + std::to_string(cloud.points.size()) + " of its " + std::to_string(header.count) +
           " points. Get a complete copy";
  };
  while (cloud.points.size() < header.count) {
    if (body.empty()) {
      return cutShort();
    }
    const std::string_view row = body.substr(0, body.find('\n'));
    body.remove_prefix(std::min(body.size(), row.size() + 1));
    const auto place = [line] { return " in line " + std::to_string(line); };
    ++line;
    const char* at = row.data();
    const char* const end = at + row.size();
    std::array<double, 4> values{};
    std::size_t count = 0;
    for (at = std::find_if_not(at, end, isSpace); at != end; at = std::find_if_not(at, end, isSpace)) {
      const std::size_t axis = count < header.properties.size() ? header.properties[count].axis : values.size() - 1;
      const auto [rest, error] = std::from_chars(at, end, values[axis]);
      if (rest != end && *rest == ',') {
        return "has a comma" + place() + ". Write decimal points, and spaces between the numbers";
      }
      if (error != std::errc() || (rest != end && !isSpace(*rest))) {
        return "has something that is no number" + place() + ". Get an undamaged copy";
      }
      at = rest;
      ++count;
    }
    if (count == 0) {
      continue;
    }
    if (count < header.properties.size() && body.empty()) {
      return cutShort();
    }
    if (count != header.properties.size()) {
      return "has " + std::to_string(count) + " numbers" + place() + ", and its points have " +
             std::to_string(header.properties.size()) + ". Write one point in a line";
    }
    cloud.points.push_back({values[0], values[1], values[2]});
  }
  return std::nullopt;
}

/// The vertices of a binary body.
std::optional<std::string> readBinary(std::string_view body, const PlyHeader& header, PointCloud& cloud) {
  std::size_t recordBytes = 0;
  for (const PlyProperty& property : header.properties) {
    recordBytes += property.type.bytes;
  }
  if (body.size() / recordBytes < header.count) {
    return "is cut short: it holds " + std::to_string(body.size() / recordBytes) + " of its " +
           std::to_string(header.count) + " points. Get a complete copy";
  }
  cloud.points.reserve(header.count);
  std::size_t at = 0;
  for (std::uint64_t i = 0; i < header.count; ++i) {
    std::array<double, 4> values{};
    for (const PlyProperty& property : header.properties) {
      values[property.axis] = numberAt(body, at, property.type, header.format == PlyFormat::BigEndian);
      at += property.type.bytes;
    }
    cloud.points.push_back({values[0], values[1], values[2]});
  }
  return std::nullopt;
}

}  // namespace

PointCloudOrProblem readPlyPoints(std::string_view bytes) {
  const auto header = readHeader(bytes);
  if (!header) {
    return tl::unexpected(header.error());
  }
  if (header->count > kMostCloudPoints) {
    return tl::unexpected("has " + std::to_string(header->count) + " points, more than " +
                          std::to_string(kMostCloudPoints) + ". Thin it out or cut it into tiles");
  }
  PointCloud cloud;
  const std::string_view body = bytes.substr(header->body);
  const auto linesBefore = std::ranges::count(bytes.substr(0, header->body), '\n');
  auto problem = header->format == PlyFormat::Ascii
                     ? readAscii(body, *header, static_cast<std::size_t>(linesBefore) + 1, cloud)
                     : readBinary(body, *header, cloud);
  if (problem) {
    return tl::unexpected(std::move(*problem));
  }
  for (const core::Vec3& point : cloud.points) {
    if (!(std::abs(point.x) < 1e100 && std::abs(point.y) < 1e100 && std::abs(point.z) < 1e100)) {
      return tl::unexpected(std::string("has a point that is not finite. Take it out"));
    }
  }
  return cloud;
}

}  // namespace espalier::files
