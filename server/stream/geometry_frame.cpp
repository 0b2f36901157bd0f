#include "server/stream/geometry_frame.h"

#include <algorithm>
#include <cstring>

#include "engine/core/streams.h"
#include "engine/turtle/export/exporters.h"
#include "protocol/json_writer.h"
#include "server/remote/translation/translate_geometry.h"
#include "server/stream/row_selection.h"

namespace espalier::server {
namespace {

// on the wire, of a row or a vertex or a triangle: five numbers of four bytes and eight of eight, and so on
constexpr std::uint64_t kSegmentBytes = 84;
constexpr std::uint64_t kOrganBytes = 32;
constexpr std::uint64_t kVertexBytes = 24;
constexpr std::uint64_t kTriangleBytes = 12;

std::uint64_t wireBytes(std::uint64_t segments, std::uint64_t organs, std::uint64_t vertices, std::uint64_t triangles) {
  return kSegmentBytes * segments + kOrganBytes * organs + kVertexBytes * vertices + kTriangleBytes * triangles;
}

std::uint64_t wireBytes(const turtle::Geometry& geometry) {
  return wireBytes(geometry.segments.size(), geometry.organs.size(), geometry.vertices.size(),
                   geometry.triangles.size());
}

std::uint64_t wireBytes(const protocol::GeometryColumns& columns) {
  return wireBytes(columns.segmentPlant.size(), columns.organPlant.size(), columns.vertices.size() / 3,
                   columns.triangles.size() / 3) +
         4 * (columns.segmentRuns.size() + columns.organRuns.size());
}

/// The symbols of all Programs by the numbers of symbolNames().
class CommonSymbols {
 public:
  CommonSymbols(const simulation::PlantsView& view, const std::vector<std::string>& names) : view_(view) {
    for (const auto& program : view.programs) {
      std::vector<core::SymbolId>& common =
          ofProgram_.emplace_back(program.get(), std::vector<core::SymbolId>()).second;
      for (const auto& symbol : program->symbols) {
        const auto found = std::find(names.begin(), names.end(), symbol.name);
        common.push_back(static_cast<core::SymbolId>(found - names.begin()));
      }
    }
  }

  [[nodiscard]] core::SymbolId of(std::uint32_t plant, std::uint64_t module) const {
    const language::Program& program = view_.program(plant);
    const auto found =
        std::find_if(ofProgram_.begin(), ofProgram_.end(), [&](const auto& entry) { return entry.first == &program; });
    return found->second[program.symbolOf[view_.plants[plant].string.types()[module]]];
  }

 private:
  const simulation::PlantsView& view_;
  std::vector<std::pair<const language::Program*, std::vector<core::SymbolId>>> ofProgram_;
};

void append(turtle::GeometrySources& to, const turtle::GeometrySources& from, std::size_t row) {
  to.plant.push_back(from.plant[row]);
  to.module.push_back(from.module[row]);
  to.symbol.push_back(from.symbol[row]);
  to.colour.push_back(from.colour[row]);
  to.branchOrder.push_back(from.branchOrder[row]);
}

turtle::Geometry selected(const turtle::Geometry& all, const RowSelection& selection) {
  const auto isTaken = [&](const turtle::GeometrySources& rows, std::size_t row) {
    return selection.takes(rows.plant[row], rows.symbol[row]);
  };
  turtle::Geometry some;
  some.areWidthsPixels = all.areWidthsPixels;
  for (std::size_t row = 0; row < all.segments.size(); ++row) {
    if (isTaken(all.segments, row)) {
      append(some.segments, all.segments, row);
      some.start.push_back(all.start[row]);
      some.end.push_back(all.end[row]);
      some.startWidth.push_back(all.startWidth[row]);
      some.endWidth.push_back(all.endWidth[row]);
    }
  }
  for (std::size_t row = 0; row < all.organs.size(); ++row) {
    if (!isTaken(all.organs, row)) {
      continue;
    }
    append(some.organs, all.organs, row);
    some.kind.push_back(all.kind[row]);
    const std::uint64_t begin = all.vertexOffset[row];
    const auto moved = static_cast<std::uint32_t>(begin - some.vertices.size());
    for (std::uint64_t i = begin; i < all.vertexOffset[row + 1]; ++i) {
      some.vertices.push_back(all.vertices[i]);
    }
    for (std::uint64_t i = all.triangleOffset[row]; i < all.triangleOffset[row + 1]; ++i) {
      const auto& [a, b, c] = all.triangles[i];
      some.triangles.push_back({a - moved, b - moved, c - moved});
    }
    some.vertexOffset.push_back(some.vertices.size());
    some.triangleOffset.push_back(some.triangles.size());
  }
  return some;
}

/// As Simulation::program.
const language::Program& firstProgram(const simulation::PlantsView& view) {
  return view.plants.empty() ? *view.programs.front() : view.program(0);
}

protocol::Body bodyOf(const protocol::GeometryColumns& columns, const protocol::StreamOpenParams& params) {
  protocol::JsonWriter json;
  json.useSinglePrecision(params.isSinglePrecision);
  json.key("geometry");
  protocol::write(json, columns, params.isInBlocks);
  protocol::Body body(json.take());
  if (params.isInBlocks) {
    addBlocks(body.blocks, columns, params.isSinglePrecision);
    body.blocks.own(columns.owner);
  }
  return body;
}

}  // namespace

tl::expected<protocol::Body, core::SimulationError> geometryBody(simulation::ViewDrawing& drawing) {
  const auto drawn = drawing.scene();
  if (!drawn) {
    return tl::unexpected(drawn.error());
  }
  const turtle::ExportInput input{.scene = *drawn,
                                  .view = drawing.settings(),
                                  .palette = &drawing.view().options->palette,
                                  .usesInstancing = true,
                                  .program = &firstProgram(drawing.view())};
  core::StringSink file;
  const turtle::ExportTarget target{.fileName = "plant.glb", .sink = file, .openCompanion = {}, .progress = {}};
  if (const auto problem = turtle::findExportFormat("glb")->write(input, target)) {
    return tl::unexpected(core::SimulationError{.code = core::SimulationErrorCode::LimitExceeded,
                                                .message = "The plants cannot be drawn: " + *problem,
                                                .step = drawing.view().completedSteps});
  }
  const std::string& bytes = file.text();
  std::vector<std::uint32_t> words(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(std::uint32_t));
  protocol::Body body(protocol::JsonWriter().key("format").text("glb").take());
  const std::uint64_t count = words.size();
  body.blocks.keep("glb", std::move(words), {count});
  return body;
}

std::uint64_t GeometryFrame::bytes() const {
  return wireBytes(*geometry);
}

tl::expected<GeometryFrame, core::SimulationError> makeGeometryFrame(
    simulation::ViewDrawing& drawing, std::shared_ptr<const std::vector<std::string>> symbols,
    const protocol::StreamSelection& select) {
  auto drawn = drawing.scene();
  if (!drawn) {
    return tl::unexpected(std::move(drawn.error()));
  }
  auto geometry = std::make_shared<turtle::Geometry>();
  const CommonSymbols common(drawing.view(), *symbols);
  try {
    turtle::appendGeometry(
        std::move(*drawn), drawing.settings(),
        [&common](std::uint32_t plant, std::uint64_t module) { return common.of(plant, module); }, *geometry);
  } catch (const core::SimulationFailure& failure) {
    return tl::unexpected(failure.error());
  }
  if (!select.symbols.empty() || !select.plants.empty()) {
    *geometry = selected(*geometry, RowSelection(*symbols, select));
  }
  return GeometryFrame{std::move(symbols), std::move(geometry)};
}

protocol::Body encodeGeometry(const std::shared_ptr<const GeometryFrame>& frame,
                              const protocol::StreamOpenParams& params) {
  return bodyOf(toColumns(frame->geometry, nullptr, *frame->symbols), params);
}

std::optional<protocol::Body> encodeDifference(const std::shared_ptr<const GeometryFrame>& frame,
                                               const GeometryFrame* base, const protocol::StreamOpenParams& params) {
  if (base == nullptr || *base->symbols != *frame->symbols) {
    return std::nullopt;
  }
  const protocol::GeometryColumns columns = toColumns(frame->geometry, base->geometry.get(), *frame->symbols);
  if (wireBytes(columns) >= wireBytes(*frame->geometry)) {
    return std::nullopt;
  }
  return bodyOf(columns, params);
}

}  // namespace espalier::server
