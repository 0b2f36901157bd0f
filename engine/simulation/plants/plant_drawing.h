#pragma once

#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/population.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// Draws the plants as they are, for pictures and streams. Drawing changes nothing: what the blocks of a homomorphism
/// do to variables is taken back. Everything that it is made from must outlive it.
class PlantDrawing {
 public:
  PlantDrawing(const ModelSet& models, const SimulationOptions& options, Population& population)
      : models_(&models), options_(&options), population_(&population) {}

  /// All living plants into one output, in the common numbers of symbols, surfaces, contours and colours. Throws
  /// SimulationFailure.
  void draw(turtle::InterpretationOutput output);
  /// The turtle records of all plants as a chain; `base` as in Simulation::recordChain. Throws SimulationFailure.
  void chainRecords(const turtle::RecordChain* base, turtle::RecordChain& chain);

 private:
  void drawPlant(std::size_t plant, const turtle::InterpretationOutput& output);

  const ModelSet* models_;
  const SimulationOptions* options_;
  Population* population_;
};

}  // namespace espalier::simulation
