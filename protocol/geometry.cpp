#include "protocol/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "protocol/decoding/column_reader.h"
#include "protocol/decoding/member.h"
#include "protocol/json_writer.h"
#include "protocol/payload.h"

namespace espalier::protocol {
namespace {

template <typename T>
struct Column {
  const char* name;
  std::span<const T> GeometryColumns::*member;
  std::uint64_t width;  // numbers of a row; 1: the rows are numbers
};

using Integers = Column<std::uint32_t>;
using Numbers = Column<double>;

// the columns of each table, the first of which says how many rows it has
constexpr std::array kRuns{Integers{"segmentRuns", &GeometryColumns::segmentRuns, 3},
                           Integers{"organRuns", &GeometryColumns::organRuns, 3}};
constexpr std::array kSegmentIntegers{Integers{"segmentPlant", &GeometryColumns::segmentPlant, 1},
                                      Integers{"segmentModule", &GeometryColumns::segmentModule, 1},
                                      Integers{"segmentSymbol", &GeometryColumns::segmentSymbol, 1},
                                      Integers{"segmentColour", &GeometryColumns::segmentColour, 1},
                                      Integers{"segmentOrder", &GeometryColumns::segmentOrder, 1}};
constexpr std::array kSegmentNumbers{Numbers{"segmentStart", &GeometryColumns::segmentStart, 3},
                                     Numbers{"segmentEnd", &GeometryColumns::segmentEnd, 3},
                                     Numbers{"segmentStartWidth", &GeometryColumns::segmentStartWidth, 1},
                                     Numbers{"segmentEndWidth", &GeometryColumns::segmentEndWidth, 1}};
constexpr std::array kOrganIntegers{Integers{"organPlant", &GeometryColumns::organPlant, 1},
                                    Integers{"organModule", &GeometryColumns::organModule, 1},
                                    Integers{"organSymbol", &GeometryColumns::organSymbol, 1},
                                    Integers{"organColour", &GeometryColumns::organColour, 1},
                                    Integers{"organOrder", &GeometryColumns::organOrder, 1},
                                    Integers{"organKind", &GeometryColumns::organKind, 1},
                                    Integers{"organVertices", &GeometryColumns::organVertices, 1},
                                    Integers{"organTriangles", &GeometryColumns::organTriangles, 1}};
constexpr Numbers kVertices{"vertices", &GeometryColumns::vertices, 3};
constexpr Integers kTriangles{"triangles", &GeometryColumns::triangles, 3};

constexpr std::uint32_t kMostColour = 255;
constexpr std::uint32_t kMostKind = 4;

void writeValue(JsonWriter& writer, double value) {
  writer.number(value);
}
void writeValue(JsonWriter& writer, std::uint32_t value) {
  writer.integer(value);
}

using Shape = std::vector<std::uint64_t>;

void addColumn(BlockWriter& blocks, const char* name, std::span<const std::uint32_t> numbers, Shape shape, bool) {
  blocks.add(name, numbers, std::move(shape));
}
void addColumn(BlockWriter& blocks, const char* name, std::span<const double> numbers, Shape shape,
               bool isSinglePrecision) {
  const double most = isSinglePrecision ? std::numeric_limits<float>::max() : std::numeric_limits<double>::max();
  // also false for NaN
  if (!std::all_of(numbers.begin(), numbers.end(), [most](double number) { return std::fabs(number) <= most; })) {
    throw NonFiniteNumber();
  }
  if (!isSinglePrecision) {
    blocks.add(name, numbers, std::move(shape));
    return;
  }
  std::vector<float> narrow(numbers.size());
  std::transform(numbers.begin(), numbers.end(), narrow.begin(),
                 [](double number) { return static_cast<float>(number); });
  blocks.keep(name, std::move(narrow), std::move(shape));
}

template <typename Visit>
void visitColumns(const GeometryColumns& geometry, Visit&& visit) {
  const auto all = [&](const auto& columns) {
    for (const auto& column : columns) {
      visit(column.name, geometry.*column.member, column.width);
    }
  };
  if (geometry.isDifference) {
    all(kRuns);
  }
  all(kSegmentIntegers);
  all(kSegmentNumbers);
  all(kOrganIntegers);
  visit(kVertices.name, geometry.*kVertices.member, kVertices.width);
  visit(kTriangles.name, geometry.*kTriangles.member, kTriangles.width);
}

/// The numbers of columns that came as text.
struct GeometryStorage {
  std::vector<std::unique_ptr<std::vector<double>>> numbers;
  std::vector<std::unique_ptr<std::vector<std::uint32_t>>> integers;
};

/// Reads the columns of one geometry, from text or from blocks.
class GeometryReader {
 public:
  GeometryReader(const Member& member, const Payload& payload)
      : member_(member), isInBlocks_(payload.blocks() != nullptr), blocks_(payload) {}

  template <typename T>
  void read(const Column<T>& column, std::optional<std::uint64_t> rows = std::nullopt) {
    geometry_.*column.member = values<T>(column, rows);
  }
  [[nodiscard]] std::uint64_t rows(const Integers& column) const {
    return (geometry_.*column.member).size() / column.width;
  }
  template <typename T>
  [[noreturn]] void fail(const Column<T>& column, std::size_t i, const std::string& what) const {
    std::string place = std::string(column.name) + "[" + std::to_string(i / column.width) + "]";
    if (column.width > 1) {
      place += "[" + std::to_string(i % column.width) + "]";
    }
    if (isInBlocks_) {
      failBlock(place, what);
    }
    throw MemberFailure{memberError(member_.path() + "." + place, what)};
  }
  void requireAtMost(const Integers& column, std::uint64_t bound, const char* what) const {
    const auto values = geometry_.*column.member;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] > bound) {
        fail(column, i, std::string("expected ") + what + ", found " + std::to_string(values[i]));
      }
    }
  }
  [[nodiscard]] GeometryColumns& geometry() { return geometry_; }
  [[nodiscard]] std::shared_ptr<GeometryStorage> storage() const { return storage_; }

 private:
  template <typename T>
  std::span<const T> values(const Column<T>& column, std::optional<std::uint64_t> rows) {
    if (isInBlocks_) {
      const BlockDescription& block = blocks_.required(column.name);
      const std::uint64_t count = rows ? *rows : rowsOf(block);
      const auto* checked =
          blocks_.column(column.name, count, column.width > 1 ? std::optional(column.width) : std::nullopt);
      if constexpr (std::is_same_v<T, double>) {
        return blocks_.numbers(checked, *storage_->numbers.emplace_back(std::make_unique<std::vector<double>>()));
      } else {
        return blocks_.integers(checked);
      }
    }
    const Member list = member_[column.name];
    const std::size_t count = list.arraySize();
    if (rows && count != *rows) {
      list.fail("expected " + std::to_string(*rows) + " rows, found " + std::to_string(count));
    }
    auto& values = store<T>();
    values.reserve(count * column.width);
    for (std::size_t i = 0; i < count; ++i) {
      const Member row = list.element(i);
      if (column.width == 1) {
        values.push_back(valueOf<T>(row));
        continue;
      }
      if (row.arraySize() != column.width) {
        row.failExpected(std::to_string(column.width) + " numbers");
      }
      for (std::size_t k = 0; k < column.width; ++k) {
        values.push_back(valueOf<T>(row.element(k)));
      }
    }
    return values;
  }
  template <typename T>
  std::vector<T>& store() {
    if constexpr (std::is_same_v<T, double>) {
      return *storage_->numbers.emplace_back(std::make_unique<std::vector<double>>());
    } else {
      return *storage_->integers.emplace_back(std::make_unique<std::vector<std::uint32_t>>());
    }
  }
  template <typename T>
  static T valueOf(const Member& member) {
    if constexpr (std::is_same_v<T, double>) {
      return member.number();
    } else {
      return static_cast<std::uint32_t>(member.integer(0, 0xFFFFFFFF));
    }
  }

  const Member& member_;
  bool isInBlocks_;
  ColumnReader blocks_;
  GeometryColumns geometry_;
  std::shared_ptr<GeometryStorage> storage_ = std::make_shared<GeometryStorage>();
};

/// The organs' meshes take all vertices and triangles, and each triangle its own organ's vertices.
void checkMeshes(GeometryReader& reader) {
  const GeometryColumns& geometry = reader.geometry();
  std::uint64_t triangle = 0;
  std::uint64_t vertexCount = 0;
  for (std::size_t organ = 0; organ < geometry.organVertices.size(); ++organ) {
    vertexCount += geometry.organVertices[organ];
    const std::uint64_t end = triangle + geometry.organTriangles[organ];
    if (end > reader.rows(kTriangles)) {
      reader.fail(kOrganIntegers[7], organ,
                  "expected no more triangles than came, " + std::to_string(reader.rows(kTriangles)) + " in all");
    }
    for (; triangle < end; ++triangle) {
      for (std::uint64_t i = 3 * triangle; i < 3 * triangle + 3; ++i) {
        if (geometry.triangles[i] >= geometry.organVertices[organ]) {
          reader.fail(kTriangles, i,
                      "organ " + std::to_string(organ) + " has " + std::to_string(geometry.organVertices[organ]) +
                          " vertices, there is no vertex " + std::to_string(geometry.triangles[i]));
        }
      }
    }
  }
  if (triangle != reader.rows(kTriangles)) {
    reader.fail(kTriangles, 3 * triangle, "this triangle belongs to no organ");
  }
  if (vertexCount != geometry.vertices.size() / 3) {
    reader.fail(kVertices, 0,
                "the organs have " + std::to_string(vertexCount) + " vertices, but " +
                    std::to_string(geometry.vertices.size() / 3) + " came");
  }
}

}  // namespace

void write(JsonWriter& writer, const GeometryColumns& geometry, bool isInBlocks) {
  writer.beginObject().key("form").text(geometry.isDifference ? "difference" : "whole");
  writer.key("widths").text(geometry.areWidthsPixels ? "pixels" : "world");
  writer.key("symbols").texts(geometry.symbols);
  if (!isInBlocks) {
    visitColumns(geometry, [&writer](const char* name, auto values, std::uint64_t width) {
      writer.key(name).beginArray();
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (width > 1 && i % width == 0) {
          writer.beginArray();
        }
        writeValue(writer, values[i]);
        if (width > 1 && i % width == width - 1) {
          writer.endArray();
        }
      }
      writer.endArray();
    });
  }
  writer.endObject();
}

void addBlocks(BlockWriter& blocks, const GeometryColumns& geometry, bool isSinglePrecision) {
  visitColumns(geometry, [&](const char* name, auto values, std::uint64_t width) {
    addColumn(blocks, name, values, width > 1 ? Shape{values.size() / width, width} : Shape{values.size()},
              isSinglePrecision);
  });
}

GeometryColumns readGeometry(const Member& member, const Payload& payload) {
  member.requireObject();
  GeometryReader reader(member, payload);
  GeometryColumns& geometry = reader.geometry();
  const std::string& form = member["form"].text();
  if (form != "whole" && form != "difference") {
    member["form"].failExpected("whole or difference");
  }
  geometry.isDifference = form == "difference";
  const std::string& widths = member["widths"].text();
  if (widths != "pixels" && widths != "world") {
    member["widths"].failExpected("pixels or world");
  }
  geometry.areWidthsPixels = widths == "pixels";
  const Member symbols = member["symbols"];
  for (std::size_t i = 0; i < symbols.arraySize(); ++i) {
    geometry.symbols.push_back(symbols.element(i).text());
  }

  if (geometry.isDifference) {
    reader.read(kRuns[0]);
    reader.read(kRuns[1]);
  }
  reader.read(kSegmentIntegers[0]);
  const std::uint64_t segments = reader.rows(kSegmentIntegers[0]);
  for (std::size_t i = 1; i < kSegmentIntegers.size(); ++i) {
    reader.read(kSegmentIntegers[i], segments);
  }
  for (const Numbers& column : kSegmentNumbers) {
    reader.read(column, segments);
  }
  reader.read(kOrganIntegers[0]);
  const std::uint64_t organs = reader.rows(kOrganIntegers[0]);
  for (std::size_t i = 1; i < kOrganIntegers.size(); ++i) {
    reader.read(kOrganIntegers[i], organs);
  }
  reader.read(kVertices);
  reader.read(kTriangles);

  for (const Integers* column : {&kSegmentIntegers[2], &kOrganIntegers[2]}) {
    for (std::size_t i = 0; i < (geometry.*column->member).size(); ++i) {
      if ((geometry.*column->member)[i] >= geometry.symbols.size()) {
        reader.fail(*column, i,
                    "there is no symbol " + std::to_string((geometry.*column->member)[i]) + "; geometry.symbols has " +
                        std::to_string(geometry.symbols.size()));
      }
    }
  }
  reader.requireAtMost(kSegmentIntegers[3], kMostColour, "a colour from 0 to 255");
  reader.requireAtMost(kOrganIntegers[3], kMostColour, "a colour from 0 to 255");
  reader.requireAtMost(kOrganIntegers[5], kMostKind, "a kind from 0 to 4");
  checkMeshes(reader);
  geometry.owner = std::make_shared<std::pair<Payload, std::shared_ptr<GeometryStorage>>>(payload, reader.storage());
  return std::move(geometry);
}

}  // namespace espalier::protocol
