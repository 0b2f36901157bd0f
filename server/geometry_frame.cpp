#include "server/geometry_frame.h"

#include <cstring>

#include "engine/core/streams.h"
#include "engine/turtle/export/exporters.h"
#include "protocol/json_writer.h"

namespace espalier::server {

std::variant<protocol::Body, core::SimulationError> geometryBody(const simulation::Simulation& simulation) {
  const auto drawn = simulation.scene();
  if (const auto* error = std::get_if<core::SimulationError>(&drawn)) {
    return *error;
  }
  const turtle::ExportInput input{.scene = std::get<turtle::Scene>(drawn),
                                  .view = simulation.view(),
                                  .palette = &simulation.options().palette,
                                  .program = &simulation.program()};
  core::StringSink file;
  const turtle::ExportTarget target{.fileName = "plant.glb", .sink = file, .openCompanion = {}, .progress = {}};
  if (const auto problem = turtle::findExportFormat("glb")->write(input, target)) {
    return core::SimulationError{.code = core::SimulationErrorCode::LimitExceeded,
                                 .message = "The plants cannot be drawn: " + *problem,
                                 .step = simulation.completedSteps()};
  }
  const std::string& bytes = file.text();
  std::vector<std::uint32_t> words(bytes.size() / sizeof(std::uint32_t));
  std::memcpy(words.data(), bytes.data(), words.size() * sizeof(std::uint32_t));
  protocol::Body body(protocol::JsonWriter().key("format").text("glb").take());
  const std::uint64_t count = words.size();
  body.blocks.keep("glb", std::move(words), {count});
  return body;
}

}  // namespace espalier::server
