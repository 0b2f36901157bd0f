#pragma once

#include <string>
#include <vector>

#include "engine/simulation/simulation.h"

namespace espalier::benchmarking {

/// The models of the gallery (`clients/gallery/NAME/NAME.l`), by name.
[[nodiscard]] std::vector<std::string> galleryModels();

/// A simulation of a model file as `espalier run` makes it of the model's folder: with the environment file beside the
/// model and with the folder's `world.json` (duration of a step, weather). Throws std::runtime_error.
[[nodiscard]] simulation::Simulation simulationOf(const std::shared_ptr<const language::Program>& program,
                                                  const std::string& modelFile);

}  // namespace espalier::benchmarking
