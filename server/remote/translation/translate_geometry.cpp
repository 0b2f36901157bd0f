#include "server/remote/translation/translate_geometry.h"

#include <algorithm>
#include <cstring>
#include <unordered_map>

#include "engine/turtle/scene/geometry_difference.h"

namespace espalier::server {
namespace {

static_assert(sizeof(core::Vec3) == 3 * sizeof(double), "columns of vectors are columns of numbers");

std::span<const double> numbersOf(const std::vector<core::Vec3>& vectors) {
  return {reinterpret_cast<const double*>(vectors.data()), 3 * vectors.size()};
}

std::vector<core::Vec3> vectorsOf(std::span<const double> numbers) {
  std::vector<core::Vec3> vectors(numbers.size() / 3);
  if (!vectors.empty()) {
    std::memcpy(static_cast<void*>(vectors.data()), numbers.data(), numbers.size_bytes());
  }
  return vectors;
}

/// The columns that had to be converted for the wire, and the geometry that the rest refers to.
struct ConvertedGeometry {
  std::shared_ptr<const turtle::Geometry> geometry;
  turtle::GeometryDifference difference;
  std::vector<std::uint32_t> segmentRuns, organRuns;
  std::vector<std::uint32_t> segmentModule, segmentSymbol, segmentColour;
  std::vector<std::uint32_t> organModule, organSymbol, organColour, organKind, organVertices, organTriangles, triangles;
};

// modules beyond 2^32 are counted modulo 2^32, as those of queries
template <typename T>
std::vector<std::uint32_t> widened(const std::vector<T>& values) {
  std::vector<std::uint32_t> wide;
  wide.reserve(values.size());
  for (const T value : values) {
    wide.push_back(static_cast<std::uint32_t>(value));
  }
  return wide;
}

std::vector<std::uint32_t> flattened(const std::vector<turtle::GeometryRun>& runs) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(3 * runs.size());
  for (const turtle::GeometryRun& run : runs) {
    numbers.insert(numbers.end(), {run.first, run.count, static_cast<std::uint32_t>(run.moduleShift)});
  }
  return numbers;
}

std::vector<std::uint32_t> countsOf(const std::vector<std::uint64_t>& offset) {
  std::vector<std::uint32_t> counts;
  counts.reserve(offset.size());
  for (std::size_t i = 0; i + 1 < offset.size(); ++i) {
    counts.push_back(static_cast<std::uint32_t>(offset[i + 1] - offset[i]));
  }
  return counts;
}

std::vector<std::uint32_t> ownTriangles(const turtle::Geometry& geometry) {
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * geometry.triangles.size());
  for (std::size_t organ = 0; organ < geometry.organs.size(); ++organ) {
    for (std::uint64_t t = geometry.triangleOffset[organ]; t < geometry.triangleOffset[organ + 1]; ++t) {
      for (const std::uint32_t corner : geometry.triangles[t]) {
        corners.push_back(static_cast<std::uint32_t>(corner - geometry.vertexOffset[organ]));
      }
    }
  }
  return corners;
}

turtle::GeometrySources toSources(std::span<const std::uint32_t> plant, std::span<const std::uint32_t> module,
                                  std::span<const std::uint32_t> symbol, std::span<const std::uint32_t> colour,
                                  std::span<const std::uint32_t> order, const std::vector<core::SymbolId>& ids) {
  turtle::GeometrySources sources;
  sources.plant.assign(plant.begin(), plant.end());
  sources.module.assign(module.begin(), module.end());
  sources.branchOrder.assign(order.begin(), order.end());
  for (const std::uint32_t index : symbol) {
    sources.symbol.push_back(ids[index]);
  }
  for (const std::uint32_t index : colour) {
    sources.colour.push_back(static_cast<std::uint8_t>(index));
  }
  return sources;
}

turtle::Geometry rowsOf(const protocol::GeometryColumns& columns, std::vector<std::string>& symbols) {
  const std::vector<core::SymbolId> ids = idsOf(columns.symbols, symbols);
  turtle::Geometry geometry;
  geometry.areWidthsPixels = columns.areWidthsPixels;
  geometry.segments = toSources(columns.segmentPlant, columns.segmentModule, columns.segmentSymbol,
                                columns.segmentColour, columns.segmentOrder, ids);
  geometry.start = vectorsOf(columns.segmentStart);
  geometry.end = vectorsOf(columns.segmentEnd);
  geometry.startWidth.assign(columns.segmentStartWidth.begin(), columns.segmentStartWidth.end());
  geometry.endWidth.assign(columns.segmentEndWidth.begin(), columns.segmentEndWidth.end());
  geometry.organs = toSources(columns.organPlant, columns.organModule, columns.organSymbol, columns.organColour,
                              columns.organOrder, ids);
  geometry.vertices = vectorsOf(columns.vertices);
  geometry.triangles.reserve(columns.triangles.size() / 3);
  for (std::size_t organ = 0; organ < columns.organKind.size(); ++organ) {
    geometry.kind.push_back(static_cast<turtle::GeometryKind>(columns.organKind[organ]));
    const std::uint64_t first = geometry.vertexOffset.back();
    const std::uint64_t end = geometry.triangles.size() + columns.organTriangles[organ];
    while (geometry.triangles.size() < end) {
      const std::uint32_t* own = columns.triangles.data() + 3 * geometry.triangles.size();
      const auto corner = [&](std::size_t k) { return static_cast<std::uint32_t>(first + own[k]); };
      geometry.triangles.push_back({corner(0), corner(1), corner(2)});
    }
    geometry.vertexOffset.push_back(first + columns.organVertices[organ]);
    geometry.triangleOffset.push_back(geometry.triangles.size());
  }
  return geometry;
}

std::vector<turtle::GeometryRun> toRuns(std::span<const std::uint32_t> numbers) {
  std::vector<turtle::GeometryRun> runs;
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    // a shift back is a shift on, modulo 2^32
    const auto shift = static_cast<std::uint64_t>(std::int64_t{static_cast<std::int32_t>(numbers[i + 2])});
    runs.push_back({numbers[i], numbers[i + 1], shift});
  }
  return runs;
}

}  // namespace

std::vector<core::SymbolId> idsOf(const std::vector<std::string>& names, std::vector<std::string>& symbols) {
  std::unordered_map<std::string, core::SymbolId> idOf;
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    idOf.emplace(symbols[i], static_cast<core::SymbolId>(i));
  }
  std::vector<core::SymbolId> ids;
  for (const std::string& name : names) {
    const auto [entry, isNew] = idOf.emplace(name, static_cast<core::SymbolId>(symbols.size()));
    if (isNew) {
      symbols.push_back(name);
    }
    ids.push_back(entry->second);
  }
  return ids;
}

protocol::GeometryColumns toColumns(std::shared_ptr<const turtle::Geometry> geometry, const turtle::Geometry* before,
                                    const std::vector<std::string>& symbols) {
  auto converted = std::make_shared<ConvertedGeometry>();
  protocol::GeometryColumns columns;
  columns.isDifference = before != nullptr;
  converted->geometry = std::move(geometry);
  if (columns.isDifference) {
    converted->difference = turtle::differenceOf(*before, *converted->geometry);
    converted->segmentRuns = flattened(converted->difference.segments);
    converted->organRuns = flattened(converted->difference.organs);
    columns.segmentRuns = converted->segmentRuns;
    columns.organRuns = converted->organRuns;
  }
  const turtle::Geometry& rows = columns.isDifference ? converted->difference.added : *converted->geometry;
  columns.areWidthsPixels = rows.areWidthsPixels;
  columns.symbols = symbols;
  // the name of a symbol without one
  for (const auto* ids : {&rows.segments.symbol, &rows.organs.symbol}) {
    for (const core::SymbolId id : *ids) {
      columns.symbols.resize(std::max<std::size_t>(columns.symbols.size(), id + std::size_t{1}), "?");
    }
  }

  converted->segmentModule = widened(rows.segments.module);
  converted->segmentSymbol = widened(rows.segments.symbol);
  converted->segmentColour = widened(rows.segments.colour);
  columns.segmentPlant = rows.segments.plant;
  columns.segmentModule = converted->segmentModule;
  columns.segmentSymbol = converted->segmentSymbol;
  columns.segmentColour = converted->segmentColour;
  columns.segmentOrder = rows.segments.branchOrder;
  columns.segmentStart = numbersOf(rows.start);
  columns.segmentEnd = numbersOf(rows.end);
  columns.segmentStartWidth = rows.startWidth;
  columns.segmentEndWidth = rows.endWidth;

  converted->organModule = widened(rows.organs.module);
  converted->organSymbol = widened(rows.organs.symbol);
  converted->organColour = widened(rows.organs.colour);
  converted->organVertices = countsOf(rows.vertexOffset);
  converted->organTriangles = countsOf(rows.triangleOffset);
  converted->triangles = ownTriangles(rows);
  for (const turtle::GeometryKind kind : rows.kind) {
    converted->organKind.push_back(static_cast<std::uint32_t>(kind));
  }
  columns.organPlant = rows.organs.plant;
  columns.organModule = converted->organModule;
  columns.organSymbol = converted->organSymbol;
  columns.organColour = converted->organColour;
  columns.organOrder = rows.organs.branchOrder;
  columns.organKind = converted->organKind;
  columns.organVertices = converted->organVertices;
  columns.organTriangles = converted->organTriangles;
  columns.vertices = numbersOf(rows.vertices);
  columns.triangles = converted->triangles;
  columns.owner = std::move(converted);
  return columns;
}

std::optional<std::string> toGeometry(const protocol::GeometryColumns& columns, const turtle::Geometry* before,
                                      std::vector<std::string>& symbols, turtle::Geometry& geometry) {
  turtle::Geometry rows = rowsOf(columns, symbols);
  if (!columns.isDifference) {
    geometry = std::move(rows);
    return std::nullopt;
  }
  if (before == nullptr) {
    return "it is a difference, but no geometry came before it";
  }
  return turtle::applyDifference(*before, {toRuns(columns.segmentRuns), toRuns(columns.organRuns), std::move(rows)},
                                 geometry);
}

}  // namespace espalier::server
