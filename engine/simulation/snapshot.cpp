#include "engine/simulation/snapshot.h"

#include <utility>

#include "engine/simulation/snapshot_content.h"

namespace espalier::simulation {

std::variant<SnapshotInfo, core::SimulationError> readSnapshotInfo(std::string_view snapshot) {
  auto read = readSnapshot(snapshot, true);
  if (auto* error = std::get_if<core::SimulationError>(&read)) {
    return std::move(*error);
  }
  SnapshotContent& content = std::get<SnapshotContent>(read);
  SnapshotInfo info;
  info.version = kSnapshotVersion;
  info.compileInput.modelFile = content.modelFile;
  info.compileInput.viewFile = content.viewFile;
  info.compileInput.compatibility = content.compatibility;
  info.compileInput.defines = std::move(content.defines);
  for (auto& [name, text] : content.sources) {
    info.files.add(std::move(name), std::move(text));
  }
  info.name = std::move(content.name);
  info.programHash = content.programHash;
  info.completedSteps = content.completedSteps;
  info.seed = content.seed;
  info.hasSeed = content.hasSeed;
  info.derivationLength = content.derivationLength;
  info.plantCount = static_cast<std::uint32_t>(content.placements.size());
  info.placements = std::move(content.placements);
  info.environmentOrigin = std::move(content.environmentOrigin);
  info.palette = std::move(content.palette);
  info.environmentName = std::move(content.environmentName);
  return info;
}

}  // namespace espalier::simulation
