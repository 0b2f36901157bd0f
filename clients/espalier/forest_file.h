#pragma once

#include <optional>
#include <string>

#include "clients/espalier/model_loading.h"
#include "engine/core/streams.h"

namespace espalier::command {

/// The forest file that MODEL names: a `.json` file, or a folder's forest.json when the folder has no specifications.
/// Nothing: MODEL is one model.
[[nodiscard]] std::optional<std::string> forestFileOf(const std::string& model);

/// Reads a forest: its models, the places of its plants, its environment. File names are relative to the folder of the
/// forest file. Options of the command line win over the file. docs/command-line.md, 4, describes the format. Prints
/// errors on standard error and returns nothing after an error.
[[nodiscard]] std::optional<LoadedModel> loadForest(const std::string& file, ModelOptions& options,
                                                    core::FileProvider& files);

}  // namespace espalier::command
