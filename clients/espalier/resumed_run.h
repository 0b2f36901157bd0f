#pragma once

#include <optional>
#include <string>

#include "clients/espalier/model_loading.h"
#include "engine/core/streams.h"
#include "engine/simulation/snapshot.h"

namespace espalier::command {

/// A snapshot file and what it says about itself.
struct ResumedRun {
  std::string bytes;
  simulation::SnapshotInfo info;
};

/// Reads a snapshot. Writes an error, naming `option` when it is not empty, and returns nothing when it cannot be read.
[[nodiscard]] std::optional<ResumedRun> readResumedRun(const std::string& file, const std::string& option,
                                                       core::FileProvider& files);

/// The model of a snapshot, or the one that `options` name, ready to be restored: with its environment and colours.
[[nodiscard]] std::optional<LoadedModel> loadResumed(ModelOptions& options, simulation::SnapshotInfo& info,
                                                     core::FileProvider& files);

}  // namespace espalier::command
