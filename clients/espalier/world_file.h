#pragma once

#include <optional>
#include <string>

#include "clients/espalier/model_loading.h"
#include "engine/core/streams.h"
#include "engine/turtle/world.h"
#include "protocol/messages.h"

namespace espalier::command {

/// The file of a model folder or a forest's folder that holds the world.
inline constexpr const char* kWorldFile = "world.json";

/// The world.json of the folder that `options` names as its model; empty: there is none.
[[nodiscard]] std::string worldFileOf(const ModelOptions& options);

/// The world in a file with the text of its table of weather, as a server takes it. Prints errors on standard error and
/// returns nothing after an error.
[[nodiscard]] std::optional<protocol::WorldRecord> readWorldFile(const std::string& file, core::FileProvider& files);

/// The world of a run: that of --world, else of `file` (empty: the default), with --step-duration. Prints errors on
/// standard error and returns nothing after an error.
[[nodiscard]] std::optional<turtle::World> loadWorld(const ModelOptions& options, const std::string& file,
                                                     core::FileProvider& files);

/// The world of a record, whose weather is the name of a table beside `file`, with --step-duration.
[[nodiscard]] std::optional<turtle::World> completeWorld(protocol::WorldRecord record, const std::string& file,
                                                         const ModelOptions& options, core::FileProvider& files);

}  // namespace espalier::command
