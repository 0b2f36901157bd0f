#pragma once

#include <optional>
#include <string>

#include "protocol/errors.h"
#include "protocol/messages.h"

namespace espalier::server {

/// A gallery folder may be a forest: it holds a `forest.json` (clients/espalier/README.md). When `params` ask for such
/// a gallery model and say nothing of plants, the forest's models, plants and seeds take the place of `model`, and its
/// environment, derivation length and seed are used where `params` have none. Returns what is wrong with the file;
/// nothing otherwise, also when there is no forest.
[[nodiscard]] std::optional<protocol::Error> expandGalleryForest(const std::string& galleryFolder,
                                                                 protocol::CreateParams& params);

}  // namespace espalier::server
