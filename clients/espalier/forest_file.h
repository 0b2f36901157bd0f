#pragma once

#include <optional>
#include <string>

#include "clients/espalier/model_loading.h"
#include "engine/core/streams.h"

namespace espalier::command {

/// The forest file that MODEL names: a `.json` file, or a folder's forest.json when the folder has no specifications.
/// Nothing: MODEL is one model.
[[nodiscard]] std::optional<std::string> forestFileOf(const std::string& model);

/// Reads a forest: the models it lists, where its plants stand, its environment. Files are found from the forest file's
/// folder; options of the command line win over what the file says. The format is in README.md. Writes what is wrong
/// to standard error; nothing on an error.
[[nodiscard]] std::optional<LoadedModel> loadForest(const std::string& file, ModelOptions& options,
                                                    core::FileProvider& files);

}  // namespace espalier::command
