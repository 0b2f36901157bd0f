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

/// Whether something says what the world of a run is: --world, --step-duration, or `file` that is not empty.
[[nodiscard]] bool hasWorld(const ModelOptions& options, const std::string& file);

/// The world of a run as a record with the text of its table of weather: that of --world, else of `file` (empty: the
/// default), with --step-duration. Prints errors on standard error and returns nothing after an error.
[[nodiscard]] std::optional<protocol::WorldRecord> readWorld(const ModelOptions& options, const std::string& file,
                                                             core::FileProvider& files);

/// The world of a run: that of --world, else of `file` (empty: the default), with --step-duration. Prints errors on
/// standard error and returns nothing after an error.
[[nodiscard]] std::optional<turtle::World> loadWorld(const ModelOptions& options, const std::string& file,
                                                     core::FileProvider& files);

/// A record whose weather is the name of a table beside `file`, with the table's text and --step-duration. Prints
/// errors on standard error and returns nothing after an error.
[[nodiscard]] std::optional<protocol::WorldRecord> completeRecord(protocol::WorldRecord record, const std::string& file,
                                                                  const ModelOptions& options,
                                                                  core::FileProvider& files);

/// The world of a run with the text that tells it from others; the text is empty when nothing says what the world is.
struct ChosenWorld {
  turtle::World world;
  std::string text;
};

/// loadWorld() with its text. Prints errors on standard error and returns nothing after an error.
[[nodiscard]] std::optional<ChosenWorld> chooseWorld(const ModelOptions& options, const std::string& file,
                                                     core::FileProvider& files);

/// The text of a complete record, for ChosenWorld.
[[nodiscard]] std::string worldText(const protocol::WorldRecord& record);

/// The world of a record, whose weather is the name of a table beside `file`, with --step-duration.
[[nodiscard]] std::optional<turtle::World> completeWorld(protocol::WorldRecord record, const std::string& file,
                                                         const ModelOptions& options, core::FileProvider& files);

/// The world of a complete record, which `file` gave. Prints errors on standard error and returns nothing after an
/// error.
[[nodiscard]] std::optional<turtle::World> worldOf(const protocol::WorldRecord& record, const std::string& file);

}  // namespace espalier::command
