#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/files/colour_files.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/interpretation/interpreter.h"

namespace espalier::simulation {

/// One of the models of a snapshot.
struct SnapshotModel {
  std::string modelFile;
  std::string viewFile;
  std::vector<std::pair<std::string, std::string>> defines;
  std::vector<std::pair<std::string, std::string>> sources;  // name, text
  std::uint64_t programHash = 0;
  std::vector<std::pair<std::string, std::uint16_t>> types;  // module types of the strings: name and arity
};

/// Everything in a snapshot, as plain data. The layout of the bytes is in FORMATS.md.
struct SnapshotContent {
  std::vector<SnapshotModel> models{1};
  core::Compatibility compatibility = core::Compatibility::Espalier;  // of all
  // the run
  std::string name;
  std::uint64_t seed = 0;
  bool hasSeed = false;
  std::uint64_t derivationLength = 0;
  std::uint64_t completedSteps = 0;
  std::vector<Plant> members;
  SeedRules seeds;
  files::Palette palette;  // of pictures
  Coupling coupling;
  turtle::World world;
  // the state after the last completed step
  std::vector<derivation::PlantState> plants;
  // the environment
  std::string environmentName;  // empty: none
  EnvironmentOrigin environmentOrigin;
  std::string environmentState;
  // the step that is under way
  bool isAnswered = false;  // the strings held the replies when the snapshot was made
  bool hasReplies = false;
  bool hasTicked = false;
  turtle::ReplyBatch replies;
};

/// Writes a snapshot in pieces, the checksum last.
void writeSnapshot(const SnapshotContent& content, core::ByteSink& sink);

/// Reads a snapshot. With `headOnly` the plants, the environment's state and the replies are left out. Errors name the
/// reason: not a snapshot, a newer version, cut off, damaged. The values are right by themselves; adoptPrograms
/// (snapshot_check.h) checks whether they fit the Programs.
[[nodiscard]] tl::expected<SnapshotContent, core::SimulationError> readSnapshot(std::string_view snapshot,
                                                                                bool headOnly);

/// A SimulationError of code Snapshot.
[[nodiscard]] core::SimulationError snapshotError(std::string message);

}  // namespace espalier::simulation
