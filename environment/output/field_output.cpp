#include "environment/output/field_output.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/base64.h"
#include "environment/base/json_text.h"
#include "environment/base/number_text.h"
#include "environment/output/vtk_arrays.h"

namespace espalier::environment {

namespace {

using turtle::Field;

/// More cells than any field here has.
constexpr std::size_t kMostCells = std::size_t{1} << 30;
/// Numbers that a file may unpack, in all: a small file can ask for many.
constexpr std::size_t kMostUnpacked = std::size_t{1} << 28;
constexpr std::string_view kHowToWrite =
    "write it with SetDataModeToAppended or SetDataModeToBinary, and SetCompressorTypeToZLib or "
    "SetCompressorTypeToNone";

std::string littleEndian(std::uint64_t word) {
  std::string bytes;
  for (int i = 0; i < 8; ++i) {
    bytes.push_back(static_cast<char>((word >> (8 * i)) & 0xFFU));
  }
  return bytes;
}

std::string bytesOf(const std::vector<double>& values) {
  std::string bytes;
  bytes.reserve(8 * values.size());
  for (const double value : values) {
    bytes += littleEndian(std::bit_cast<std::uint64_t>(value));
  }
  return bytes;
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char character : text) {
    result += character == '&'   ? "&amp;"
              : character == '<' ? "&lt;"
              : character == '"' ? "&quot;"
                                 : std::string(1, character);
  }
  return result;
}

std::string unescaped(std::string text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kNames{
      {{"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}}};
  for (const auto& [name, character] : kNames) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
      text.replace(at, name.size(), character);
    }
  }
  return text;
}

std::string threeNumbers(double a, double b, double c) {
  return numberText(a) + " " + numberText(b) + " " + numberText(c);
}

/// The first element of a name from a place on: its attributes, and the text up to the next tag.
struct Element {
  std::string_view attributes;
  std::string_view content;
  std::size_t end = 0;  // behind the opening tag
};

std::optional<Element> findElement(std::string_view text, std::string_view name, std::size_t from) {
  for (std::size_t at = text.find('<', from); at != std::string_view::npos; at = text.find('<', at + 1)) {
    const std::string_view rest = text.substr(at + 1);
    if (rest.substr(0, name.size()) != name || rest.find_first_of(" \t\r\n/>") != name.size()) {
      continue;
    }
    const std::size_t close = rest.find('>');
    if (close == std::string_view::npos) {
      return std::nullopt;
    }
    return Element{rest.substr(name.size(), close - name.size()),
                   rest.substr(close + 1, rest.find('<', close) - close - 1), at + close + 2};
  }
  return std::nullopt;
}

std::optional<std::string> attribute(const Element& element, std::string_view name) {
  const std::string start = std::string(name) + "=\"";
  for (std::size_t at = element.attributes.find(start); at != std::string_view::npos;
       at = element.attributes.find(start, at + 1)) {
    if (at == 0 || element.attributes[at - 1] == ' ' || element.attributes[at - 1] == '\n' ||
        element.attributes[at - 1] == '\t') {
      const std::string_view value = element.attributes.substr(at + start.size());
      return unescaped(std::string(value.substr(0, value.find('"'))));
    }
  }
  return std::nullopt;
}

std::vector<double> numbersIn(std::string_view text) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* end = text.data() + text.size();
  while (at != end) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error == std::errc()) {
      numbers.push_back(value);
      at = next;
    } else {
      ++at;
    }
  }
  return numbers;
}

template <typename Number>
void appendNumbers(std::string_view bytes, std::vector<double>& values) {
  for (std::size_t at = 0; at + sizeof(Number) <= bytes.size(); at += sizeof(Number)) {
    Number number{};
    std::memcpy(&number, bytes.data() + at, sizeof(Number));
    values.push_back(static_cast<double>(number));
  }
}

/// Numbers of a VTK type as doubles; nothing for an unknown type.
std::optional<std::vector<double>> numbersOfType(std::string_view bytes, std::string_view type) {
  std::vector<double> values;
  if (type == "Float64") {
    appendNumbers<double>(bytes, values);
  } else if (type == "Float32") {
    appendNumbers<float>(bytes, values);
  } else if (type == "Int64") {
    appendNumbers<std::int64_t>(bytes, values);
  } else if (type == "UInt64") {
    appendNumbers<std::uint64_t>(bytes, values);
  } else if (type == "Int32") {
    appendNumbers<std::int32_t>(bytes, values);
  } else if (type == "UInt32") {
    appendNumbers<std::uint32_t>(bytes, values);
  } else if (type == "Int16") {
    appendNumbers<std::int16_t>(bytes, values);
  } else if (type == "UInt16") {
    appendNumbers<std::uint16_t>(bytes, values);
  } else if (type == "Int8") {
    appendNumbers<std::int8_t>(bytes, values);
  } else if (type == "UInt8") {
    appendNumbers<std::uint8_t>(bytes, values);
  } else {
    return std::nullopt;
  }
  return values;
}

/// How the file packs its arrays; the error is a sentence.
tl::expected<VtkPacking, std::string> packingOf(const Element& file, std::string_view text, std::size_t from) {
  VtkPacking packing{.hasLongHeader = attribute(file, "header_type").value_or("UInt32") == "UInt64"};
  if (attribute(file, "byte_order").value_or("LittleEndian") != "LittleEndian") {
    return tl::unexpected(std::string("is big-endian: write it with SetByteOrderToLittleEndian"));
  }
  if (const auto compressor = attribute(file, "compressor"); compressor && !compressor->empty()) {
    if (*compressor != "vtkZLibDataCompressor") {
      return tl::unexpected("is compressed by '" + compressor->substr(0, 60) + "': " + std::string(kHowToWrite));
    }
    packing.isCompressed = true;
  }
  const auto appended = findElement(text, "AppendedData", from);
  const std::size_t start = appended ? text.find('_', appended->end) : std::string_view::npos;
  if (start != std::string_view::npos) {
    packing.appended = text.substr(start + 1);
    packing.isAppendedBase64 = attribute(*appended, "encoding").value_or("base64") == "base64";
  }
  return packing;
}

tl::expected<std::vector<double>, std::string> dataOf(const Element& array, const VtkPacking& packing,
                                                      std::size_t most) {
  const std::string format = attribute(array, "format").value_or("ascii");
  if (format == "ascii") {
    return numbersIn(array.content);
  }
  const bool isAppended = format == "appended";
  if (format != "binary" && !isAppended) {
    return tl::unexpected("has data of the format '" + format + "': " + std::string(kHowToWrite));
  }
  std::string_view data = array.content;
  if (isAppended) {
    const auto offset = numbersIn(attribute(array, "offset").value_or(""));
    if (offset.size() != 1 || !(offset[0] >= 0.0 && offset[0] < static_cast<double>(packing.appended.size()))) {
      return tl::unexpected(std::string("has a data array that is damaged or cut short. Get a complete copy"));
    }
    data = packing.appended.substr(static_cast<std::size_t>(offset[0]));
  }
  const std::string type = attribute(array, "type").value_or("Float64");
  tl::expected<std::string, std::string> bytes;
  if (isAppended || packing.isCompressed) {
    bytes = unpackedBytes(data, !isAppended || packing.isAppendedBase64, packing,
                          most * (type.ends_with('8')    ? 1
                                  : type.ends_with("16") ? 2
                                  : type.ends_with("32") ? 4
                                                         : 8));
    if (!bytes) {
      return tl::unexpected(std::move(bytes.error()));
    }
  } else {
    const std::size_t header = packing.hasLongHeader ? 8 : 4;
    const auto all = fromBase64Pieces(data, data.size());
    if (!all || all->size() < header) {
      return tl::unexpected(std::string("has a data array that is no base64, or is cut short. Get a complete copy"));
    }
    bytes = all->substr(header);
  }
  auto values = numbersOfType(*bytes, type);
  if (!values) {
    return tl::unexpected("has a data array of the unknown type '" + type + "'");
  }
  return std::move(*values);
}

}  // namespace

std::string writeVti(std::span<const Field> fields, std::string_view lengthUnit) {
  const Field& first = fields.front();
  const std::string extent = "0 " + std::to_string(first.cells[0]) + " 0 " + std::to_string(first.cells[1]) + " 0 " +
                             std::to_string(first.cells[2]);
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<ImageData WholeExtent=\"" +
      extent + "\" Origin=\"" + threeNumbers(first.position.x, first.position.y, first.position.z) + "\" Spacing=\"" +
      threeNumbers(first.cellSize.x, first.cellSize.y, first.cellSize.z) + "\"" +
      (lengthUnit == "m" ? std::string() : " LengthUnit=\"" + escaped(lengthUnit) + "\"") + ">\n<Piece Extent=\"" +
      extent + "\">\n<CellData Scalars=\"" + escaped(first.name) + "\">\n";
  for (const Field& field : fields) {
    text += "<DataArray type=\"Float64\" Name=\"" + escaped(field.name) + "\" Unit=\"" + escaped(field.unit) +
            "\" format=\"binary\">\n" + core::toBase64(littleEndian(8 * field.values.size()) + bytesOf(field.values)) +
            "\n</DataArray>\n";
  }
  return text + "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
}

tl::expected<std::vector<Field>, std::string> readVti(std::string_view text) {
  const auto file = findElement(text, "VTKFile", 0);
  const auto image = file ? findElement(text, "ImageData", file->end) : std::nullopt;
  const auto cells = image ? findElement(text, "CellData", image->end) : std::nullopt;
  if (!cells) {
    return tl::unexpected(
        std::string("is no VTK image data file (.vti) with cell data. `python3 -m espalier.fields FILE out.vti` makes "
                    "one of netCDF and Zarr"));
  }
  const auto packing = packingOf(*file, text, cells->end);
  if (!packing) {
    return tl::unexpected(packing.error());
  }
  const std::vector<double> extent = numbersIn(attribute(*image, "WholeExtent").value_or(""));
  const std::vector<double> origin = numbersIn(attribute(*image, "Origin").value_or("0 0 0"));
  const std::vector<double> spacing = numbersIn(attribute(*image, "Spacing").value_or("1 1 1"));
  Field shape;
  if (extent.size() != 6 || origin.size() != 3 || spacing.size() != 3) {
    return tl::unexpected(std::string("has no extent of six numbers, or an origin or spacing without three"));
  }
  std::size_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = extent[2 * axis + 1] - extent[2 * axis];
    if (!(size >= 1.0) || size * static_cast<double>(count) > static_cast<double>(kMostCells)) {
      return tl::unexpected(std::string("has an extent without cells, or with too many"));
    }
    shape.cells[axis] = static_cast<std::size_t>(size);
    count *= shape.cells[axis];
  }
  shape.cellSize = {spacing[0], spacing[1], spacing[2]};
  shape.position = {origin[0] + extent[0] * spacing[0], origin[1] + extent[2] * spacing[1],
                    origin[2] + extent[4] * spacing[2]};
  std::size_t unpacked = 0;
  std::vector<Field> fields;
  const std::size_t last = text.find("</CellData", cells->end);
  for (auto array = findElement(text, "DataArray", cells->end); array && array->end < last;
       array = findElement(text, "DataArray", array->end)) {
    unpacked += packing->isCompressed || !packing->appended.empty() ? count : 0;
    if (unpacked > kMostUnpacked) {
      return tl::unexpected("has more than " + std::to_string(kMostUnpacked) +
                            " numbers in packed arrays. Write fewer quantities into a file");
    }
    auto data = dataOf(*array, *packing, count);
    if (!data) {
      return tl::unexpected(std::move(data.error()));
    }
    Field field = shape;
    field.name = attribute(*array, "Name").value_or("");
    field.unit = attribute(*array, "Unit").value_or("1");
    field.values = std::move(*data);
    if (field.values.size() != count) {
      return tl::unexpected("has " + std::to_string(field.values.size()) + " numbers in '" + field.name + "' for " +
                            std::to_string(count) + " cells");
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

std::string writeRaw(const Field& field) {
  return bytesOf(field.values);
}

std::string writeRawHeader(const Field& field) {
  nlohmann::ordered_json header;
  header["name"] = field.name;
  header["unit"] = field.unit;
  header["cells"] = field.cells;
  header["position"] = {field.position.x, field.position.y, field.position.z};
  header["cellSize"] = {field.cellSize.x, field.cellSize.y, field.cellSize.z};
  header["type"] = "float64";
  header["byteOrder"] = "little";
  header["order"] = "x fastest, then y, then z";
  return header.dump(2) + "\n";
}

tl::expected<Field, std::string> readRaw(std::string_view header, std::string_view bytes) {
  const auto parsed = parseJson(header, "header");
  if (!parsed) {
    return tl::unexpected(std::string("has a header that is no JSON"));
  }
  const nlohmann::json& json = *parsed;
  const auto numbers = [&](const char* key) {
    std::vector<double> values;
    if (json.is_object() && json.contains(key) && json[key].is_array()) {
      for (const auto& value : json[key]) {
        values.push_back(value.is_number() ? value.get<double>() : std::nan(""));
      }
    }
    values.resize(values.size() == 3 ? 3 : 0);
    return values;
  };
  const auto cells = numbers("cells");
  const auto position = numbers("position");
  const auto size = numbers("cellSize");
  if (cells.empty() || position.empty() || size.empty()) {
    return tl::unexpected(std::string("has a header without three 'cells', a 'position' and a 'cellSize'"));
  }
  const auto text = [&](const char* key, const char* otherwise) {
    return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string(otherwise);
  };
  if (text("type", "float64") != "float64" || text("byteOrder", "little") != "little") {
    return tl::unexpected(std::string("is not of the type float64, little-endian"));
  }
  Field field;
  field.name = text("name", "");
  field.unit = text("unit", "1");
  double count = 1.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    count *= cells[axis];
    field.cells[axis] = cells[axis] >= 1.0 && cells[axis] < 1e9 ? static_cast<std::size_t>(cells[axis]) : 0;
  }
  field.position = {position[0], position[1], position[2]};
  field.cellSize = {size[0], size[1], size[2]};
  if (count * 8.0 != static_cast<double>(bytes.size())) {
    return tl::unexpected("has " + std::to_string(bytes.size()) + " bytes instead of 8 for each of its cells");
  }
  appendNumbers<double>(bytes, field.values);
  return field;
}

tl::expected<FieldPlane, std::string> viewField(const Field& field, const FieldView& view) {
  const auto axis = static_cast<std::size_t>(view.axis);
  const std::array<double, 3> low{field.position.x, field.position.y, field.position.z};
  const std::array<double, 3> size{field.cellSize.x, field.cellSize.y, field.cellSize.z};
  std::size_t first = 0;
  std::size_t last = field.cells[axis];
  if (view.at) {
    const double place = std::floor((*view.at - low[axis]) / size[axis]);
    if (!(place >= 0.0 && place < static_cast<double>(field.cells[axis]))) {
      return tl::unexpected("'" + field.name + "' reaches from " + numberText(low[axis]) + " to " +
                            numberText(low[axis] + size[axis] * static_cast<double>(field.cells[axis])) + " along " +
                            std::string(1, "xyz"[axis]) + ": choose a slice there");
    }
    first = static_cast<std::size_t>(place);
    last = first + 1;
  }
  // to the right x, or z along x; up y, or along y z downwards, as on a map
  const std::size_t across = axis == 0 ? 2 : 0;
  const std::size_t upright = axis == 1 ? 2 : 1;
  FieldPlane plane{field.cells[across], field.cells[upright], {}};
  plane.values.assign(plane.width * plane.height, 0.0);
  std::array<std::size_t, 3> cell{};
  for (cell[2] = 0; cell[2] < field.cells[2]; ++cell[2]) {
    for (cell[1] = 0; cell[1] < field.cells[1]; ++cell[1]) {
      for (cell[0] = 0; cell[0] < field.cells[0]; ++cell[0]) {
        if (cell[axis] >= first && cell[axis] < last) {
          const std::size_t row = axis == 1 ? cell[upright] : plane.height - 1 - cell[upright];
          plane.values[row * plane.width + cell[across]] +=
              field.values[(cell[2] * field.cells[1] + cell[1]) * field.cells[0] + cell[0]] /
              static_cast<double>(last - first);
        }
      }
    }
  }
  return plane;
}

std::pair<double, double> rangeOf(const FieldPlane& plane) {
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  for (const double value : plane.values) {
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return low <= high ? std::pair(low, high) : std::pair(0.0, 0.0);
}

std::vector<std::uint8_t> colourPlane(const FieldPlane& plane, double low, double high) {
  // viridis at ninths
  constexpr std::array<std::array<double, 3>, 10> kColours{{{68, 1, 84},
                                                            {72, 40, 120},
                                                            {62, 74, 137},
                                                            {49, 104, 142},
                                                            {38, 130, 142},
                                                            {31, 158, 137},
                                                            {53, 183, 121},
                                                            {110, 206, 88},
                                                            {181, 222, 43},
                                                            {253, 231, 37}}};
  std::vector<std::uint8_t> pixels;
  pixels.reserve(4 * plane.values.size());
  for (const double value : plane.values) {
    if (std::isnan(value)) {
      pixels.insert(pixels.end(), {190, 190, 190, 255});
      continue;
    }
    const double place = high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) * 9.0 : 4.5;
    const auto below = std::min<std::size_t>(static_cast<std::size_t>(place), 8);
    const double part = place - static_cast<double>(below);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double colour = kColours[below][channel] * (1.0 - part) + kColours[below + 1][channel] * part;
      pixels.push_back(static_cast<std::uint8_t>(std::lround(colour)));
    }
    pixels.push_back(255);
  }
  return pixels;
}

FieldSummary summaryOf(const Field& field) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  FieldSummary summary{.minimum = kInfinity, .maximum = -kInfinity};
  double sum = 0.0;
  for (const double value : field.values) {
    if (std::isnan(value)) {
      continue;
    }
    ++summary.count;
    sum += value;
    summary.minimum = std::min(summary.minimum, value);
    summary.maximum = std::max(summary.maximum, value);
  }
  if (summary.count == 0) {
    const double none = field.values.empty() ? 0.0 : std::numeric_limits<double>::quiet_NaN();
    return {.minimum = none, .mean = none, .maximum = none, .integral = none};
  }
  summary.mean = sum / static_cast<double>(summary.count);
  summary.integral = sum * field.cellSize.x * field.cellSize.y * field.cellSize.z;
  return summary;
}

}  // namespace espalier::environment
