#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/random.h"
#include "engine/derivation/state/file_state.h"
#include "engine/derivation/state/module_string.h"

namespace espalier::derivation {

/// The variables of one L-system: of the main one, or of one call of a sub-L-system.
struct InstanceState {
  std::uint32_t system = 0;       // index into Program::systems
  bool hasStarted = false;        // its define block and Start have run
  std::vector<double> variables;  // by LSystem::variables
  std::vector<double> elements;   // all array elements
};

/// The random streams of one plant.
struct RandomState {
  std::uint64_t seed = 0;               // selection draws of Espalier's own mode
  std::uint64_t mainSeed = 0;           // ran and its relatives; srand replaces it
  core::SequentialRandom selection;     // the reference's selection stream
  core::SequentialRandom main{0x330E};  // the reference's main stream
  double normalCache = 0.0;             // the second value of a pair that nran keeps
  double normalCacheFlag = 10.0;        // not 0: nran keeps a value, as at the start of the reference program
};

/// Everything of a plant that a step changes. A value: a copy is complete.
struct PlantState {
  ModuleString string;
  std::uint64_t step = 0;                // completed steps; Q while the next one runs is step + 1
  std::uint64_t derivationLength = 1;    // Z; SetDerivationLength changes it
  bool isStopped = false;                // stop(n) was called, or End has run
  std::vector<double> statics;           // production-local variables (Program::staticCount)
  std::vector<InstanceState> instances;  // [0] the main L-system; others in order of their calls in the string
  RandomState random;
  FileState files;
  files::Box viewVolume;  // of vvXmin ...: the simulation sets it before each step; no snapshot keeps it
};

}  // namespace espalier::derivation
