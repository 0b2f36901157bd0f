#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/simulation/view_drawing.h"
#include "engine/turtle/scene/geometry.h"
#include "protocol/messages.h"

namespace espalier::server {

/// The body of a `geometry` frame: the plants as they are drawn now, a binary glTF file in the block `glb` (its bytes
/// as little-endian `<u4`; a file's length is a multiple of four). The model's materials and surfaces are in it.
[[nodiscard]] tl::expected<protocol::Body, core::SimulationError> geometryBody(simulation::ViewDrawing& drawing);

/// The plants as environments see them, with the names of the symbols. Never changes. Streams of differences keep it
/// until their next frame.
struct GeometryFrame {
  std::shared_ptr<const std::vector<std::string>> symbols;
  std::shared_ptr<const turtle::Geometry> geometry;

  /// Bytes of memory, about.
  [[nodiscard]] std::uint64_t bytes() const;
};

/// The segments and organs of a selection. `symbols` are those of the drawing. O(modules + vertices).
[[nodiscard]] tl::expected<GeometryFrame, core::SimulationError> makeGeometryFrame(
    simulation::ViewDrawing& drawing, std::shared_ptr<const std::vector<std::string>> symbols,
    const protocol::StreamSelection& select);

/// The body of a frame in columns, all of it. Throws protocol::NonFiniteNumber.
[[nodiscard]] protocol::Body encodeGeometry(const std::shared_ptr<const GeometryFrame>& frame,
                                            const protocol::StreamOpenParams& params);
/// The same as a difference from `base`. Nothing when there is no base (null) or the whole is as short. Throws
/// protocol::NonFiniteNumber.
[[nodiscard]] std::optional<protocol::Body> encodeDifference(const std::shared_ptr<const GeometryFrame>& frame,
                                                             const GeometryFrame* base,
                                                             const protocol::StreamOpenParams& params);

}  // namespace espalier::server
