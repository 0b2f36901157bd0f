#include "engine/turtle/export/mesh/vtp.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/base64.h"
#include "engine/turtle/export/mesh/placed_meshes.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

namespace {

// a piece is written when it has as many points
constexpr std::size_t kPointsOfPiece = 65'536;
constexpr std::size_t kParameters = 4;
constexpr std::uint16_t kUnknownSymbol = 65'535;

// the bytes of an array behind their number, as VTK wants them inline
template <typename Number>
void writeBinary(const std::vector<Number>& values, TextOutput& out) {
  static_assert(std::endian::native == std::endian::little);
  const std::uint64_t size = values.size() * sizeof(Number);
  std::string bytes(sizeof(size) + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof(size));
  if (size > 0) {
    std::memcpy(bytes.data() + sizeof(size), values.data(), size);
  }
  out << core::toBase64(bytes);
}

template <typename Number>
void writeArray(std::string_view type, std::string_view name, std::size_t components, const std::vector<Number>& values,
                TextOutput& out) {
  out << "<DataArray type=\"" << type << "\" Name=\"" << name << "\" NumberOfComponents=\""
      << std::to_string(components) << "\" format=\"binary\">";
  writeBinary(values, out);
  out << "</DataArray>\n";
}

/// The two kinds of VTK's files for meshes.
enum class VtkKind : std::uint8_t { Polygons, Grid };

/// Where the parameters of each module of a string begin, for strings whose modules are asked for in any order.
class ParameterPlaces {
 public:
  explicit ParameterPlaces(const ExportInput& input) {
    for (std::size_t plant = 0; input.program != nullptr && plant < input.strings.size(); ++plant) {
      const language::Program& program = input.programOf(plant);
      std::vector<std::uint64_t>& places = places_.emplace_back(1, 0);
      for (const core::ModuleTypeId type : input.strings[plant]->types()) {
        places.push_back(places.back() + program.arity[type]);
      }
    }
  }

  /// NaN: the module is not known or has no such parameter.
  [[nodiscard]] double parameter(const ExportInput& input, const Provenance& from, std::size_t number) const {
    if (from.plant >= places_.size() || from.module + 1 >= places_[from.plant].size()) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const std::uint64_t place = places_[from.plant][from.module] + number;
    return place < places_[from.plant][from.module + 1] ? input.strings[from.plant]->parameters()[place]
                                                        : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  std::vector<std::vector<std::uint64_t>> places_;  // by plant: (moduleCount + 1)
};

/// The points and cells that are written together.
class Piece {
 public:
  /// `named`: the program whose symbols the file lists; null: none.
  explicit Piece(const language::Program* named) : named_(named) {}
  [[nodiscard]] std::size_t pointCount() const { return points_.size() / 3; }

  void add(const PlacedMeshes::Item& item, const Mesh& mesh, const Colour& colour, const ParameterPlaces& places) {
    const auto first = static_cast<std::int64_t>(pointCount());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      addVector(points_, mesh.positions[i]);
      addVector(normals_, mesh.normals[i]);
    }
    for (const auto& face : mesh.faces) {
      for (std::size_t k = 0; k < (face[3] == Mesh::kNoVertex ? 3U : 4U); ++k) {
        corners_.push_back(first + face[k]);
      }
      ends_.push_back(static_cast<std::int64_t>(corners_.size()));
      addCell(item, item.scene.provenanceOf(item.part, mesh, face[2]), colour, places);
    }
  }

  void write(VtkKind kind, TextOutput& out) const {
    const bool isGrid = kind == VtkKind::Grid;
    out << "<Piece NumberOfPoints=\"" << std::to_string(pointCount())
        << (isGrid ? "\" NumberOfCells=\""
                   : "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"")
        << std::to_string(ends_.size()) << "\">\n<Points>\n";
    writeArray("Float32", "Points", 3, points_, out);
    out << "</Points>\n<PointData Normals=\"Normals\">\n";
    writeArray("Float32", "Normals", 3, normals_, out);
    out << "</PointData>\n<CellData Scalars=\"order\">\n";
    writeArray("UInt32", "plant", 1, plants_, out);
    writeArray("UInt64", "module", 1, modules_, out);
    writeArray("UInt16", "symbol", 1, symbols_, out);
    writeArray("UInt32", "order", 1, orders_, out);
    writeArray("Float64", "age", 1, ages_, out);
    writeArray("UInt8", "organ", 1, organs_, out);
    writeArray("UInt8", "colour", 3, colours_, out);
    for (std::size_t k = 0; k < kParameters; ++k) {
      writeArray("Float64", "parameter" + std::to_string(k + 1), 1, parameters_[k], out);
    }
    out << "</CellData>\n" << (isGrid ? "<Cells>\n" : "<Polys>\n");
    writeArray("Int64", "connectivity", 1, corners_, out);
    writeArray("Int64", "offsets", 1, ends_, out);
    if (isGrid) {
      writeArray("UInt8", "types", 1, cellTypes(), out);
    }
    out << (isGrid ? "</Cells>\n</Piece>\n" : "</Polys>\n</Piece>\n");
  }

 private:
  /// VTK's numbers for a triangle and a quad.
  [[nodiscard]] std::vector<std::uint8_t> cellTypes() const {
    std::vector<std::uint8_t> types;
    std::int64_t begin = 0;
    for (const std::int64_t end : ends_) {
      types.push_back(end - begin == 3 ? 5 : 9);
      begin = end;
    }
    return types;
  }

  static void addVector(std::vector<float>& values, const core::Vec3& v) {
    values.insert(values.end(), {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)});
  }

  /// The steps since a module came; not a number: not known.
  [[nodiscard]] static double ageOf(const ExportInput& input, const Provenance& from) {
    const bool isKnown = input.step && from.plant < input.births.size() &&
                         from.module < input.births[from.plant].size() &&
                         input.births[from.plant][from.module] <= *input.step;
    return isKnown ? static_cast<double>(*input.step - input.births[from.plant][from.module])
                   : std::numeric_limits<double>::quiet_NaN();
  }

  void addCell(const PlacedMeshes::Item& item, const Provenance& from, const Colour& colour,
               const ParameterPlaces& places) {
    const ExportInput& input = item.scene.input();
    const bool isKnown = input.program != nullptr && from.plant < input.strings.size() &&
                         from.module < input.strings[from.plant]->size();
    plants_.push_back(item.copy.firstPlant + from.plant);
    modules_.push_back(from.module);
    symbols_.push_back(isKnown && &input.programOf(from.plant) == named_
                           ? input.programOf(from.plant).symbolOf[input.strings[from.plant]->types()[from.module]]
                           : kUnknownSymbol);
    orders_.push_back(from.branchOrder);
    ages_.push_back(ageOf(input, from));
    organs_.push_back(static_cast<std::uint8_t>(item.part.kind));
    colours_.insert(colours_.end(), {colour.red, colour.green, colour.blue});
    for (std::size_t k = 0; k < kParameters; ++k) {
      parameters_[k].push_back(places.parameter(input, from, k));
    }
  }

  const language::Program* named_;
  std::vector<float> points_, normals_;       // (pointCount · 3)
  std::vector<std::int64_t> corners_, ends_;  // of all cells, concatenated; where each cell's corners end (cellCount)
  std::vector<std::uint32_t> plants_, orders_;
  std::vector<std::uint64_t> modules_;
  std::vector<double> ages_;
  std::vector<std::uint16_t> symbols_;
  std::vector<std::uint8_t> organs_, colours_;  // (cellCount), (cellCount · 3)
  std::array<std::vector<double>, kParameters> parameters_;
};

// a name as VTK writes text: its characters as numbers, behind each name a 0
void writeSymbols(const language::Program* program, TextOutput& out) {
  const std::size_t count = program == nullptr ? 0 : program->symbols.size();
  out << "<FieldData>\n<DataArray type=\"String\" Name=\"symbols\" NumberOfTuples=\"" << std::to_string(count)
      << "\" format=\"ascii\">";
  for (std::size_t i = 0; i < count; ++i) {
    for (const char character : std::string_view(program->symbols[i].name)) {
      out.integer(static_cast<unsigned char>(character)) << ' ';
    }
    out << "0 ";
  }
  out << "</DataArray>\n</FieldData>\n";
}

std::optional<std::string> exportVtk(VtkKind kind, const PlacedScenes& placed, const ExportTarget& target) {
  PlacedMeshes meshes(placed);
  std::vector<ParameterPlaces> places;
  for (const ExportInput& input : placed.scenes) {
    places.emplace_back(input);
  }
  TextOutput out(target.sink);
  const std::string_view name = kind == VtkKind::Grid ? "UnstructuredGrid" : "PolyData";
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"" << name
      << "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<" << name << ">\n";
  writeSymbols(placed.scenes[0].program, out);
  Piece piece(placed.scenes[0].program);
  std::uint64_t done = 0;
  auto problem = meshes.forEach([&](const PlacedMeshes::Item& item, const Mesh& mesh) -> std::optional<std::string> {
    piece.add(item, mesh, meshes.materials()[item.part.material].colour, places[item.copy.scene]);
    if (piece.pointCount() >= kPointsOfPiece) {
      piece.write(kind, out);
      piece = Piece(placed.scenes[0].program);
    }
    reportProgress(target.progress, ++done, meshes.partCount());
    return std::nullopt;
  });
  piece.write(kind, out);
  out << "</" << name << ">\n</VTKFile>\n";
  out.flush();
  return problem;
}

}  // namespace

std::optional<std::string> exportVtp(const PlacedScenes& placed, const ExportTarget& target) {
  return exportVtk(VtkKind::Polygons, placed, target);
}

std::optional<std::string> exportVtu(const PlacedScenes& placed, const ExportTarget& target) {
  return exportVtk(VtkKind::Grid, placed, target);
}

}  // namespace espalier::turtle
