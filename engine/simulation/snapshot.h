#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// First bytes of a snapshot file, then the version as a little-endian 32-bit number. The layout is in
/// engine/simulation/README.md.
inline constexpr std::string_view kSnapshotMagic = "ESPALIER";
inline constexpr std::uint32_t kSnapshotVersion = 2;

/// What one of a snapshot's models is compiled from.
struct SnapshotSource {
  language::CompileInput compileInput;  // names into `files`
  core::MemoryFileProvider files;       // every source of the model
  std::uint64_t programHash = 0;
};

/// The name of an environment that has not yet said what it is, because it is away: any environment's state may be
/// restored into it, and what is saved with it into any environment.
inline constexpr std::string_view kUnknownEnvironment = "?";

/// What a snapshot says about itself, enough to compile its model and create a Simulation to restore it into.
struct SnapshotInfo {
  std::uint32_t version = kSnapshotVersion;
  std::vector<SnapshotSource> models;  // at least one
  std::string name;                    // of the simulation
  std::uint64_t completedSteps = 0;
  std::uint64_t seed = 0;  // SimulationOptions::seed
  bool hasSeed = false;
  std::uint64_t derivationLength = 0;
  std::uint32_t plantCount = 1;
  std::vector<Plant> plants;            // (plantCount), living and dead
  SeedRules seeds;                      // SimulationOptions::seeds
  EnvironmentOrigin environmentOrigin;  // how the caller that saved had made it
  std::string environmentName;          // empty: none
  files::Palette palette;               // of pictures
};

/// The Programs of a snapshot, compiled within `limits`, or the diagnostics of the first that does not compile.
[[nodiscard]] std::variant<Programs, core::DiagnosticList> compileModels(SnapshotInfo& info,
                                                                         const core::Limits& limits);

/// Reads the head of a snapshot. Errors say what is wrong: not a snapshot, a newer version, cut off.
[[nodiscard]] std::variant<SnapshotInfo, core::SimulationError> readSnapshotInfo(std::string_view snapshot);

}  // namespace espalier::simulation
