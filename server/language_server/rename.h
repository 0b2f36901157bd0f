#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <tl/expected.hpp>
#include "engine/core/streams.h"
#include "server/language_server/model_analysis.h"

namespace espalier::server {

/// A replacement in a file of a model.
struct TextEdit {
  std::uint32_t file = 0;  // index into the analysis' files
  std::uint32_t offset = 0;
  std::uint32_t length = 0;
};

/// The places to be replaced when a name gets another one; or the reason why it may not. `files` gives the model's
/// files: the result is analysed again, and a name that would get another meaning is refused.
[[nodiscard]] tl::expected<std::vector<TextEdit>, std::string> renameEdits(const ModelAnalysis& analysis,
                                                                           const language::NameUse& name,
                                                                           const std::string& newName,
                                                                           core::FileProvider& files);

}  // namespace espalier::server
