#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/streams.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/trace.h"
#include "tests/fuzz/pieces.h"
#include "tests/fuzz/run_files.h"
#include "tests/fuzz/small_limits.h"
#include "tests/fuzz/targets.h"

namespace espalier::fuzz {
namespace {

constexpr int kSnapshotSteps = 2;

/// The models of a snapshot, compiled once for each hash: restore compares the hash with the Program's, and what
/// compiling does with a stranger's text is another target.
const simulation::Programs* programsOf(simulation::SnapshotInfo& info) {
  constexpr std::size_t kMostModels = 4;
  static std::map<std::vector<std::uint64_t>, simulation::Programs> known;
  std::vector<std::uint64_t> key;
  for (const simulation::SnapshotSource& source : info.models) {
    key.push_back(source.programHash);
    key.push_back(static_cast<std::uint64_t>(source.compileInput.compatibility));
  }
  if (const auto found = known.find(key); found != known.end()) {
    return &found->second;
  }
  if (info.models.size() > kMostModels) {
    return nullptr;
  }
  auto compiled = simulation::compileModels(info, smallLimits());
  if (!compiled) {
    return nullptr;
  }
  // no room for models that other bytes of the source made
  for (std::size_t i = 0; i < compiled->size(); ++i) {
    if ((*compiled)[i]->hash != info.models[i].programHash) {
      return nullptr;
    }
  }
  return &known.emplace(std::move(key), std::move(*compiled)).first->second;
}

}  // namespace

void fuzzSnapshot(std::string_view bytes) {
  const auto pieces = cutIntoPieces(bytes);
  const std::string snapshot = pieces && !pieces->isTrace ? joinPieces(*pieces) : std::string(bytes);
  auto read = simulation::readSnapshotInfo(snapshot);
  if (!read) {
    ESPALIER_CHECK(!read.error().message.empty());
    return;
  }
  auto& info = *read;
  const simulation::Programs* programs = programsOf(info);
  if (programs == nullptr) {
    return;
  }
  simulation::SimulationOptions options;
  options.limits = smallLimits();
  simulation::Simulation simulation(
      *programs, std::vector<simulation::PlantOrigin>(info.plants.size()),
      info.environmentName.empty() ? nullptr : makeAnsweringEnvironment(info.environmentName), options);
  if (simulation.restore(snapshot)) {
    return;
  }
  for (int step = 0; step < kSnapshotSteps; ++step) {
    const std::uint64_t completed = simulation.completedSteps();
    if (simulation.step()) {
      // a step that fails leaves everything as it was; only what a snapshot holds of a step under way is taken back
      // once
      ESPALIER_CHECK(simulation.completedSteps() == completed);
      const std::uint64_t before = simulation.stateHash();
      ESPALIER_CHECK(simulation.step().has_value());
      ESPALIER_CHECK(simulation.stateHash() == before);
      break;
    }
  }
  (void)simulation.scene();
  (void)simulation.stringText(0);
  // a restored simulation can be saved and restored again
  core::StringSink sink;
  simulation.save(sink);
  const std::uint64_t saved = simulation.stateHash();
  ESPALIER_CHECK(!simulation.restore(sink.text()));
  ESPALIER_CHECK(simulation.stateHash() == saved);
}

void fuzzTrace(std::string_view bytes) {
  const auto pieces = cutIntoPieces(bytes);
  const std::string trace = pieces && pieces->isTrace ? joinPieces(*pieces) : std::string(bytes);
  const auto replayed = simulation::replayTrace(trace, 1, {}, smallLimits());
  if (!replayed) {
    ESPALIER_CHECK(!replayed.error().empty());
  }
}

}  // namespace espalier::fuzz
