#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/source_map.h"
#include "engine/language/outline/name_uses.h"
#include "server/language_server/text_positions.h"

namespace espalier::server {

/// The program's knowledge of one model: its messages, and its names with their places.
struct ModelAnalysis {
  std::string file;  // of the model
  std::vector<core::Diagnostic> diagnostics;
  bool isForeign = true;  // another program's notation: only the messages are known
  files::SourceMap map;   // empty for a foreign model, like what follows
  std::vector<language::NameUse> names;
  std::vector<language::MacroDefinition> macros;
  std::vector<LineIndex> lines;  // by file

  /// The index of a file of the model by its name.
  [[nodiscard]] std::optional<std::uint32_t> fileIndex(const std::string& name) const;
  /// The name at an offset of a file: a macro wins over what it brings. Null: none is there.
  [[nodiscard]] const language::NameUse* nameAt(std::uint32_t file, std::uint32_t offset) const;
};

/// Analyses a model file with the `.v` file beside it. Never fails: mistakes are diagnostics.
[[nodiscard]] std::shared_ptr<const ModelAnalysis> analyseModel(const std::string& modelFile,
                                                                core::FileProvider& files);

/// The messages about a view file alone.
[[nodiscard]] std::vector<core::Diagnostic> checkViewFile(const std::string& viewFile, core::FileProvider& files);

/// Whether a document is a model: `.l` and the endings of other programs' models. Others are included, or data.
[[nodiscard]] bool isModelFile(std::string_view path);
[[nodiscard]] bool isViewFile(std::string_view path);

}  // namespace espalier::server
