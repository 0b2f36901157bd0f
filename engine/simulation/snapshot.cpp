#include "engine/simulation/snapshot.h"

#include <utility>

#include "engine/simulation/snapshot_content.h"

namespace espalier::simulation {

tl::expected<SnapshotInfo, core::SimulationError> readSnapshotInfo(std::string_view snapshot) {
  auto read = readSnapshot(snapshot, true);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  SnapshotContent& content = *read;
  SnapshotInfo info;
  info.version = kSnapshotVersion;
  for (SnapshotModel& model : content.models) {
    SnapshotSource& source = info.models.emplace_back();
    source.compileInput.modelFile = std::move(model.modelFile);
    source.compileInput.viewFile = std::move(model.viewFile);
    source.compileInput.compatibility = content.compatibility;
    source.compileInput.defines = std::move(model.defines);
    for (auto& [name, text] : model.sources) {
      source.files.add(std::move(name), std::move(text));
    }
    source.programHash = model.programHash;
  }
  info.name = std::move(content.name);
  info.completedSteps = content.completedSteps;
  info.seed = content.seed;
  info.hasSeed = content.hasSeed;
  info.derivationLength = content.derivationLength;
  info.plantCount = static_cast<std::uint32_t>(content.members.size());
  info.plants = std::move(content.members);
  info.seeds = content.seeds;
  info.environmentOrigin = std::move(content.environmentOrigin);
  info.palette = std::move(content.palette);
  info.world = std::move(content.world);
  info.environmentName = std::move(content.environmentName);
  return info;
}

tl::expected<Programs, core::DiagnosticList> compileModels(SnapshotInfo& info, const core::Limits& limits) {
  Programs programs;
  for (SnapshotSource& source : info.models) {
    source.compileInput.limits = limits;
    language::CompileResult compiled = language::compile(source.compileInput, source.files);
    if (compiled.program == nullptr) {
      return tl::unexpected(std::move(compiled.diagnostics));
    }
    programs.push_back(std::move(compiled.program));
  }
  return programs;
}

}  // namespace espalier::simulation
