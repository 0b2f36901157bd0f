#pragma once

#include <optional>
#include <string>

#include "clients/espalier/model_loading.h"
#include "engine/core/streams.h"
#include "engine/simulation/snapshot.h"

namespace espalier::command {

/// A snapshot file and its description.
struct ResumedRun {
  std::string bytes;
  simulation::SnapshotInfo info;
};

/// Reads a snapshot. Prints an error and returns nothing when it cannot be read. The error names `option` unless empty.
[[nodiscard]] std::optional<ResumedRun> readResumedRun(const std::string& file, const std::string& option,
                                                       core::FileProvider& files);

/// The model of a snapshot, or the model of `options`, with its environment and colours, ready to restore the snapshot.
[[nodiscard]] std::optional<LoadedModel> loadResumed(ModelOptions& options, simulation::SnapshotInfo& info,
                                                     core::FileProvider& files);

}  // namespace espalier::command
