#pragma once

#include <variant>

#include "engine/core/simulation_error.h"
#include "engine/simulation/simulation.h"
#include "protocol/messages.h"

namespace espalier::server {

/// The body of a `geometry` frame: the plants as they are drawn now, a binary glTF file in the block `glb` (its bytes
/// as little-endian `<u4`; a file's length is a multiple of four). The model's materials and surfaces are in it.
[[nodiscard]] std::variant<protocol::Body, core::SimulationError> geometryBody(
    const simulation::Simulation& simulation);

}  // namespace espalier::server
