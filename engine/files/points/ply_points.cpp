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
constexpr std::size_t kMostElements = 1000;

struct PlyProperty {
  PlyType type;
  std::optional<PlyType> lengthType;  // of a list: its length stands before its numbers
  std::size_t axis = 3;               // 0 to 2: a coordinate; 3: none
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

/// The elements up to the vertices, which are the last, as the header describes them.
struct PlyHeader {
  PlyFormat format = PlyFormat::Ascii;
  std::vector<PlyElement> elements;
  std::size_t body = 0;  // first byte behind the header

  [[nodiscard]] const PlyElement& vertices() const { return elements.back(); }
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

/// Adds a property of an element.
std::optional<std::string> addProperty(const std::vector<std::string_view>& words, PlyElement& element) {
  const bool isList = words.size() == 5 && words[1] == "list";
  if (!isList && words.size() != 3) {
    return "expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'. Correct the line";
  }
  const auto* const type = std::ranges::find(kTypes, words[isList ? 3 : 1], &PlyType::name);
  const auto* const lengthType = std::ranges::find(kTypes, words[isList ? 2 : 1], &PlyType::name);
  for (const auto& [known, word] : {std::pair{lengthType, words[isList ? 2 : 1]}, {type, words[isList ? 3 : 1]}}) {
    if (known == std::end(kTypes)) {
      return "the type '" + std::string(word.substr(0, 40)) + "' is unknown. Write float or double";
    }
  }
  if (isList && lengthType->kind == 'f') {
    return "the length of a list has the type '" + std::string(words[2]) + "'. Write a type of whole numbers";
  }
  if (element.properties.size() == kMostProperties) {
    return "the element '" + std::string(element.name.substr(0, 40)) + "' has more than " +
           std::to_string(kMostProperties) + " properties. Leave some out";
  }
  const std::array<std::string_view, 3> names{"x", "y", "z"};
  const auto axis = static_cast<std::size_t>(std::ranges::find(names, words[2]) - names.begin());
  element.properties.push_back(isList ? PlyProperty{*type, *lengthType, names.size()}
                                      : PlyProperty{*type, std::nullopt, axis});
  return std::nullopt;
}

tl::expected<PlyHeader, std::string> readHeader(std::string_view bytes) {
  PlyHeader header;
  bool hasVertices = false;
  bool isBehind = false;  // an element behind the vertices, which is not looked at
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
      for (const PlyProperty& property : hasVertices ? header.vertices().properties : std::vector<PlyProperty>()) {
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
      PlyElement element{.name = words[1], .count = 0, .properties = {}};
      const auto [rest, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
      const bool isVertex = element.name == "vertex";
      isBehind = hasVertices;
      if ((isVertex && isBehind) || error != std::errc() || rest != words[2].data() + words[2].size()) {
        return refused(number, "expected one element '" + std::string(element.name.substr(0, 40)) +
                                   "' with the number of " + (isVertex ? "points" : "them") + ". Correct the number");
      }
      if (header.elements.size() == kMostElements) {
        return refused(number, "there are more than " + std::to_string(kMostElements) + " elements. Leave some out");
      }
      if (!isBehind) {
        header.elements.push_back(std::move(element));
      }
      hasVertices = hasVertices || isVertex;
    } else if (words[0] == "property" && !header.elements.empty()) {
      if (auto problem = isBehind ? std::nullopt : addProperty(words, header.elements.back())) {
        return refused(number, *problem);
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

std::string cutShort(const PlyHeader& header, std::size_t points) {
  return "is cut short: it holds " + std::to_string(points) + " of its " + std::to_string(header.vertices().count) +
         " points. Get a complete copy";
}

bool isBlankCharacter(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// The lines of an ascii body that are not empty.
class PlyLines {
 public:
  PlyLines(std::string_view body, std::size_t line) : body_(body), line_(line) {}

  /// Nothing at the end of the body.
  std::optional<std::string_view> next() {
    while (!body_.empty()) {
      const std::string_view row = body_.substr(0, body_.find('\n'));
      body_.remove_prefix(std::min(body_.size(), row.size() + 1));
      ++line_;
      if (!std::ranges::all_of(row, isBlankCharacter)) {
        return row;
      }
    }
    return std::nullopt;
  }
  [[nodiscard]] bool isAtEnd() const { return body_.empty(); }
  /// Where the last line was.
  [[nodiscard]] std::string place() const { return " in line " + std::to_string(line_ - 1); }

 private:
  std::string_view body_;
  std::size_t line_;
};

/// The vertices of an ascii body, one element in a line. Empty lines are passed over. `line` is the number of the first
/// line.
std::optional<std::string> readAscii(std::string_view body, const PlyHeader& header, std::size_t line,
                                     PointCloud& cloud) {
  PlyLines lines(body, line);
  for (const PlyElement& element : header.elements) {
    const bool isSkipped = &element != &header.vertices() && !element.properties.empty();
    for (std::uint64_t i = 0; isSkipped && i < element.count; ++i) {
      if (!lines.next()) {
        return cutShort(header, 0);
      }
    }
  }
  const std::vector<PlyProperty>& properties = header.vertices().properties;
  while (cloud.points.size() < header.vertices().count) {
    const auto row = lines.next();
    if (!row) {
      return cutShort(header, cloud.points.size());
    }
    const char* at = row->data();
    const char* const end = at + row->size();
    std::array<double, 4> values{};
    std::uint64_t count = 0;
    std::uint64_t expected = properties.size();
    std::size_t next = 0;      // property
    std::uint64_t inList = 0;  // numbers that are left of the open list
    for (at = std::find_if_not(at, end, isBlankCharacter); at != end; at = std::find_if_not(at, end, isBlankCharacter)) {
      double value = 0.0;
      const auto [rest, error] = std::from_chars(at, end, value);
      if (rest != end && *rest == ',') {
        return "has a comma" + lines.place() + ". Write decimal points, and spaces between the numbers";
      }
      if (error != std::errc() || (rest != end && !isBlankCharacter(*rest))) {
        return "has something that is no number" + lines.place() + ". Get an undamaged copy";
      }
      at = rest;
      ++count;
      if (inList > 0) {
        --inList;
      } else if (next < properties.size() && properties[next++].lengthType) {
        if (!(value >= 0.0 && value <= 4294967295.0 && value == std::floor(value))) {
          return "has a list without a length" + lines.place() + ". Get an undamaged copy";
        }
        inList = static_cast<std::uint64_t>(value);
        expected += inList;
      } else if (count <= expected) {
        values[properties[next - 1].axis] = value;
      }
    }
    if (count < expected && lines.isAtEnd()) {
      return cutShort(header, cloud.points.size());
    }
    if (count != expected) {
      return "has " + std::to_string(count) + " numbers" + lines.place() + ", and its points have " +
             std::to_string(expected) + ". Write one point in a line";
    }
    cloud.points.push_back({values[0], values[1], values[2]});
  }
  return std::nullopt;
}

/// The elements of a binary body.
class PlyRecords {
 public:
  PlyRecords(std::string_view body, bool isBigEndian) : body_(body), isBigEndian_(isBigEndian) {}

  /// The least number of bytes of an element.
  [[nodiscard]] static std::size_t leastBytes(const PlyElement& element) {
    std::size_t bytes = 0;
    for (const PlyProperty& property : element.properties) {
      bytes += property.lengthType ? property.lengthType->bytes : property.type.bytes;
    }
    return bytes;
  }
  /// How many of an element the rest can hold.
  [[nodiscard]] std::uint64_t mostOf(const PlyElement& element) const {
    const std::size_t bytes = leastBytes(element);
    return bytes == 0 ? element.count : std::min(element.count, (body_.size() - at_) / bytes);
  }
  /// Passes over all of an element; false when the body ends before.
  bool skip(const PlyElement& element) {
    if (mostOf(element) < element.count) {
      return false;
    }
    if (std::ranges::none_of(element.properties, [](const PlyProperty& each) { return each.lengthType.has_value(); })) {
      at_ += leastBytes(element) * element.count;
      return true;
    }
    std::array<double, 4> values{};
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (!read(element, values)) {
        return false;
      }
    }
    return true;
  }
  /// Reads one of an element, coordinates into the first three values; false when the body ends before, also by a list
  /// whose length is below 0 or beyond the end.
  bool read(const PlyElement& element, std::array<double, 4>& values) {
    for (const PlyProperty& property : element.properties) {
      const PlyType& type = property.lengthType ? *property.lengthType : property.type;
      if (body_.size() - at_ < type.bytes) {
        return false;
      }
      const double number = numberAt(body_, at_, type, isBigEndian_);
      at_ += type.bytes;
      if (!property.lengthType) {
        values[property.axis] = number;
        continue;
      }
      if (number < 0.0 || number > static_cast<double>((body_.size() - at_) / property.type.bytes)) {
        return false;
      }
      at_ += static_cast<std::size_t>(number) * property.type.bytes;
    }
    return true;
  }

 private:
  std::string_view body_;
  bool isBigEndian_;
  std::size_t at_ = 0;
};

/// The vertices of a binary body.
std::optional<std::string> readBinary(std::string_view body, const PlyHeader& header, PointCloud& cloud) {
  PlyRecords records(body, header.format == PlyFormat::BigEndian);
  for (std::size_t i = 0; i + 1 < header.elements.size(); ++i) {
    if (!records.skip(header.elements[i])) {
      return cutShort(header, 0);
    }
  }
  const PlyElement& vertices = header.vertices();
  if (records.mostOf(vertices) < vertices.count) {
    return cutShort(header, records.mostOf(vertices));
  }
  cloud.points.reserve(vertices.count);
  std::array<double, 4> values{};
  for (std::uint64_t i = 0; i < vertices.count; ++i) {
    if (!records.read(vertices, values)) {
      return cutShort(header, i);
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
  if (header->vertices().count > kMostCloudPoints) {
    return tl::unexpected("has " + std::to_string(header->vertices().count) + " points, more than " +
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
