#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/source_map.h"
#include "engine/language/dialects/translation.h"
#include "engine/language/program.h"

namespace espalier::language {

/// One of several models in a file.
struct DialectEntry {
  std::string name;        // as the file writes it; `FILE:NAME` chooses it, in any letter case
  std::size_t offset = 0;  // of its beginning
};

/// A notation of L-systems other than cpfg's.
struct Dialect {
  std::string_view name;   // of --dialect
  std::string_view title;  // for people
  /// Whether a text that is not a cpfg model looks like a model of this dialect.
  bool (*recognises)(std::string_view text) = nullptr;
  /// The models of a file, in order; null for dialects whose files hold one.
  std::vector<DialectEntry> (*entries)(std::string_view text) = nullptr;
  /// Reads a model: the one called `entry`, a name from `entries`; empty when the file holds only one. Mistakes go into
  /// the report; after an error the result is not used.
  CpfgModel (*translate)(std::string_view text, const std::string& entry, DialectReport& report) = nullptr;
};

/// All dialects; the first that recognises a text reads it.
[[nodiscard]] std::span<const Dialect> dialects();
/// The name of cpfg itself as a value of --dialect.
inline constexpr std::string_view kCpfgDialect = "cpfg";
/// cpfg and all others.
[[nodiscard]] std::vector<std::string_view> dialectNames();

/// Whether a line of a text begins with `Lsystem:`, so that it is a cpfg model, perhaps with mistakes.
[[nodiscard]] bool hasLsystem(std::string_view text);

/// A file of a foreign dialect and its translation.
struct TranslatedModel {
  const Dialect* dialect = nullptr;
  files::SourceMap::File foreign;  // as read; its name is without an entry
  std::string entry;               // empty: the file holds one model
  CpfgModel model;                 // not to be used when `diagnostics` has errors
  core::DiagnosticList diagnostics;
};

/// A name `FILE` or `FILE:ENTRY` in its parts. When a file with the whole name exists, there is no entry.
struct NamedEntry {
  std::string file;
  std::string entry;  // empty: none was named
};
[[nodiscard]] NamedEntry splitEntry(const std::string& name, core::FileProvider& files);

/// The names of the models in a file `FILE` (without an entry), each once, in order; empty when it holds one model or
/// cannot be read.
[[nodiscard]] std::vector<std::string> entriesOf(const CompileInput& input, core::FileProvider& files);

/// Reads input.modelFile when it is in a foreign dialect: input.dialect, or else the first that recognises the file.
/// Nothing when the file looks like a cpfg model or cannot be read.
[[nodiscard]] std::optional<TranslatedModel> translateForeign(const CompileInput& input, core::FileProvider& files);

/// The source map of a preprocessed text whose first file is a translation, with the places in the foreign file.
[[nodiscard]] files::SourceMap foreignSourceMap(const files::SourceMap& map, const MappedText& translation,
                                                const files::SourceMap::File& foreign);

}  // namespace espalier::language
