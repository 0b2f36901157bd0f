#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// First bytes of a snapshot file, then the version as a little-endian 32-bit number. The layout is in
/// engine/simulation/FORMATS.md.
inline constexpr std::string_view kSnapshotMagic = "ESPALIER";
inline constexpr std::uint32_t kSnapshotVersion = 3;

/// The sources and options of one of a snapshot's models.
struct SnapshotSource {
  language::CompileInput compileInput;  // names into `files`
  core::MemoryFileProvider files;       // every source of the model
  std::uint64_t programHash = 0;
};

/// The name of an environment in another process that is not connected yet. The state of any environment can be
/// restored into it, and its state into any environment.
inline constexpr std::string_view kUnknownEnvironment = "?";

/// The head of a snapshot: enough to compile its models and to create the Simulation that restores it.
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
  EnvironmentOrigin environmentOrigin;  // the saving caller's description of it
  std::string environmentName;          // empty: none
  files::Palette palette;               // of pictures
  turtle::World world;                  // SimulationOptions::world
};

/// The Programs of a snapshot, compiled within `limits`, or the diagnostics of the first that does not compile.
[[nodiscard]] tl::expected<Programs, core::DiagnosticList> compileModels(SnapshotInfo& info,
                                                                         const core::Limits& limits);

/// Reads the head of a snapshot. Errors name the reason: not a snapshot, a newer version, cut off, damaged.
[[nodiscard]] tl::expected<SnapshotInfo, core::SimulationError> readSnapshotInfo(std::string_view snapshot);

}  // namespace espalier::simulation
