#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/simulation/forest.h"

namespace espalier::simulation {

/// A seed that a plant drops in a step.
struct Seed {
  std::uint32_t mother = 0;   // number of the plant
  std::uint64_t module = 0;   // index of Seed(...) in the mother's string
  std::uint64_t offset = 0;   // of its parameters there; turtle::kTransientQuery: nowhere, nothing is answered
  std::uint32_t model = 0;    // of the new plant
  core::Vec3 position;        // of the turtle at the module
  bool hasTakenRoot = false;  // the outcome
};

/// Decides which seeds of one step take root (SeedRules) among plants that stand at `places`, and moves every seed down
/// or up to the ground. Two-phase: all seeds see the plants that live before the step. Where there is not room for all,
/// an order drawn from (seed, step, mother, module) decides, so that no plant has an advantage by its number. Expected
/// cost O(plants + seeds log seeds).
void settleSeeds(std::vector<Seed>& seeds, const std::vector<core::Vec3>& places, const SeedRules& rules,
                 const core::Vec3& up, std::uint64_t runSeed, std::uint64_t step);

}  // namespace espalier::simulation
