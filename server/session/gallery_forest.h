#pragma once

#include <optional>
#include <string>

#include "protocol/errors.h"
#include "protocol/messages.h"

namespace espalier::server {

/// A gallery folder that holds a `forest.json` is a forest (clients/espalier/README.md), and so are the files of a
/// folder that come with a request. When `params` have such a model and no plants, the forest's models, plants and
/// seeds replace `model`. Its environment, derivation length and seed are used where `params` have none. Returns the
/// mistake in the file; nothing otherwise, also when there is no forest.
[[nodiscard]] std::optional<protocol::Error> expandForest(const std::string& galleryFolder,
                                                          protocol::CreateParams& params);

/// The world that the `world.json` of a gallery folder, or among the files of a request, gives to `params` that have
/// none, with the table of weather that it names. After expandForest(), whose forest has a world of its own. Returns
/// the mistake in the file; nothing otherwise.
[[nodiscard]] std::optional<protocol::Error> expandWorld(const std::string& galleryFolder,
                                                         protocol::CreateParams& params);

}  // namespace espalier::server
