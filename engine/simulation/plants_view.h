#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/simulation/forest.h"
#include "engine/simulation/simulation.h"

namespace espalier::simulation {

/// The plants of a simulation at one time (Simulation::takeView). A view stays as it is while the simulation goes on:
/// their strings share memory until the simulation writes, and then the simulation goes on in other memory. Any thread
/// may read a view; a ViewDrawing draws it.
struct PlantsView {
  std::uint64_t number = 0;  // of the simulation's views, from 1
  std::uint64_t base = 0;    // the number of the view that `changes` start from; 0: they are not known
  std::shared_ptr<const SimulationOptions> options;
  Programs programs;
  std::shared_ptr<const std::vector<Plant>> members;  // by plant number, living and dead
  std::vector<derivation::PlantState> plants;         // by plant number; of the dead empty
  std::vector<derivation::StepChanges> changes;       // by plant number: what its string has of the base's
  StepStatistics statistics;
  std::uint64_t completedSteps = 0;
  bool isFinished = false;

  [[nodiscard]] const language::Program& program(std::size_t plant) const {
    return *programs[(*members)[plant].origin.model];
  }
};

}  // namespace espalier::simulation
