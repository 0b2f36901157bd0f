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
  std::string name;        // as the file writes it; `FILE:NAME` chooses it, letter case aside
  std::size_t offset = 0;  // of its beginning
};

/// A way of writing L-systems that is not cpfg's.
struct Dialect {
  std::string_view name;   // of --dialect
  std::string_view title;  // for people
  /// Whether a text that is no cpfg model looks like one of this dialect.
  bool (*recognises)(std::string_view text) = nullptr;
  /// The models of a file, in order; null for dialects whose files hold one.
  std::vector<DialectEntry> (*entries)(std::string_view text) = nullptr;
  /// Reads the model (of `entry`, one of those that `entries` found; else empty). What is wrong goes into the report;
  /// with an error the result is not used.
  CpfgModel (*translate)(std::string_view text, const std::string& entry, DialectReport& report) = nullptr;
};

/// All dialects, in the order in which they are asked whether they recognise a text.
[[nodiscard]] std::span<const Dialect> dialects();
/// The name by which --dialect asks for cpfg itself.
inline constexpr std::string_view kCpfgDialect = "cpfg";
/// cpfg and all others.
[[nodiscard]] std::vector<std::string_view> dialectNames();

/// Whether a text is a cpfg model, as far as a look at its keywords tells.
[[nodiscard]] bool looksLikeCpfg(std::string_view text);

/// A file of a foreign dialect, read and brought into cpfg's terms.
struct TranslatedModel {
  const Dialect* dialect = nullptr;
  SourceMap::File foreign;  // as read, by its name without an entry
  std::string entry;        // empty: the file holds one model
  CpfgModel model;          // not to be used when `diagnostics` has errors
  core::DiagnosticList diagnostics;
};

/// The file of a name `FILE` or `FILE:ENTRY`: the whole name when there is such a file.
struct NamedEntry {
  std::string file;
  std::string entry;  // empty: none was named
};
[[nodiscard]] NamedEntry splitEntry(const std::string& name, core::FileProvider& files);

/// Reads input.modelFile when it is in a foreign dialect: the one of input.dialect, or else the one that recognises it.
/// Nothing when it is (or is taken for) a cpfg model or cannot be read.
[[nodiscard]] std::optional<TranslatedModel> translateForeign(const CompileInput& input, core::FileProvider& files);

/// The places of a preprocessed text as places of the foreign file that its first file is a translation of.
[[nodiscard]] SourceMap foreignSourceMap(const SourceMap& map, const MappedText& translation,
                                         const SourceMap::File& foreign);

}  // namespace espalier::language
